//! A chart as SVG: lines and points over two axes.

use std::fmt::Write;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 330.0;
/// Left, right, top, bottom of the frame.
const FRAME: [f64; 4] = [70.0, 745.0, 46.0, 280.0];
/// Ticks on an axis, more or less.
const TICKS: f64 = 6.0;

/// The colours of the page: told apart by the colour-blind too.
pub const BLUE: &str = "#0062a3";
/// Of what was measured, and of offset and matrix only.
pub const ORANGE: &str = "#b34700";
/// Of the dip and the heading.
pub const GREEN: &str = "#00724f";
/// Of the noise.
pub const GREY: &str = "#6b7280";

/// One series.
pub struct Series {
    /// In the legend.
    pub label: String,
    /// Where; a value that is not finite interrupts a line.
    pub points: Vec<[f64; 2]>,
    /// An SVG colour.
    pub colour: &'static str,
    /// Points instead of a line.
    pub dots: bool,
    /// A broken line.
    pub dashed: bool,
}

/// A chart.
pub struct Chart {
    /// Above it.
    pub title: String,
    /// Under the horizontal axis.
    pub x: String,
    /// Next to the vertical axis.
    pub y: String,
    /// Both axes by powers of ten.
    pub log: bool,
    /// Both axes with the same scale.
    pub square: bool,
    /// What is drawn, the first below.
    pub series: Vec<Series>,
}

/// Text between tags.
pub fn escaped(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '&' => "&amp;".to_string(),
            '<' => "&lt;".to_string(),
            '>' => "&gt;".to_string(),
            '"' => "&quot;".to_string(),
            c if c.is_control() => "\u{fffd}".to_string(),
            c => c.to_string(),
        })
        .collect()
}

/// From values to places.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
    log: bool,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64>, from: f64, to: f64, log: bool) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.map(|v| if log { v.log10() } else { v }).filter(|v| v.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            return None;
        }
        let room = if high > low { 0.03 * (high - low) } else { 0.5 * high.abs().max(1.0) };
        Some(Axis { low: low - room, high: high + room, from, to, log })
    }

    fn at(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Round values, and what stands next to them.
    fn ticks(&self) -> Vec<(f64, String)> {
        if self.log {
            let powers = self.low.ceil() as i32..=self.high.floor() as i32;
            return powers.map(|power| (10_f64.powi(power), format!("1e{power}"))).collect();
        }
        let rough = (self.high - self.low) / TICKS;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| *step >= rough);
        let step = step.unwrap_or(rough);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let first = (self.low / step).ceil() as i64;
        (first..)
            .map(|index| index as f64 * step)
            .take_while(|value| *value <= self.high)
            .take(50)
            .map(|value| (value, format!("{value:.decimals$}")))
            .collect()
    }
}

impl Chart {
    /// The file; `None` where there is nothing to draw.
    pub fn svg(&self) -> Option<String> {
        let [left, right, top, bottom] = FRAME;
        let all = || self.series.iter().flat_map(|series| &series.points);
        let mut x = Axis::of(all().map(|p| p[0]), left, right, self.log)?;
        let mut y = Axis::of(all().map(|p| p[1]), bottom, top, self.log)?;
        if self.square {
            let per = ((x.high - x.low) / (right - left)).max((y.high - y.low) / (bottom - top));
            for (axis, length) in [(&mut x, right - left), (&mut y, bottom - top)] {
                let middle = 0.5 * (axis.low + axis.high);
                (axis.low, axis.high) = (middle - 0.5 * per * length, middle + 0.5 * per * length);
            }
        }
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" \
             font-size=\"12\">\n\
             <title>{title}</title>\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n\
             <text x=\"{left}\" y=\"18\" font-size=\"14\">{title}</text>\n",
            title = escaped(&self.title)
        );
        // Writing to a string does not fail.
        let _ = self.axes(&x, &y, &mut out);
        for series in &self.series {
            let _ = draw(series, &x, &y, &mut out);
        }
        let _ = self.legend(&mut out);
        out.push_str("</svg>\n");
        Some(out)
    }

    fn axes(&self, x: &Axis, y: &Axis, out: &mut String) -> std::fmt::Result {
        let [left, right, top, bottom] = FRAME;
        for (value, label) in x.ticks() {
            let at = x.at(value);
            writeln!(out, "<path d=\"M{at:.1} {top}V{bottom}\" stroke=\"#ddd\"/>")?;
            writeln!(
                out,
                "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
                bottom + 16.0
            )?;
        }
        for (value, label) in y.ticks() {
            let at = y.at(value);
            writeln!(out, "<path d=\"M{left} {at:.1}H{right}\" stroke=\"#ddd\"/>")?;
            writeln!(
                out,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                left - 6.0,
                at + 4.0
            )?;
        }
        let (width, height) = (right - left, bottom - top);
        writeln!(
            out,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#555\"/>"
        )?;
        let (middle, half) = (0.5 * (left + right), 0.5 * (top + bottom));
        let (below, label) = (bottom + 34.0, escaped(&self.x));
        writeln!(out, "<text x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">{label}</text>")?;
        let label = escaped(&self.y);
        writeln!(
            out,
            "<text transform=\"translate(16 {half}) rotate(-90)\" text-anchor=\"middle\">{label}</text>"
        )
    }

    fn legend(&self, out: &mut String) -> std::fmt::Result {
        let mut at = FRAME[0];
        for series in self.series.iter().filter(|series| !series.label.is_empty()) {
            let (colour, label) = (series.colour, escaped(&series.label));
            writeln!(out, "<rect x=\"{at:.0}\" y=\"28\" width=\"10\" height=\"10\" fill=\"{colour}\"/>")?;
            writeln!(out, "<text x=\"{:.0}\" y=\"37\">{label}</text>", at + 14.0)?;
            at += 28.0 + 6.6 * series.label.chars().count() as f64;
        }
        Ok(())
    }
}

fn draw(series: &Series, x: &Axis, y: &Axis, out: &mut String) -> std::fmt::Result {
    let colour = series.colour;
    let place = |point: &[f64; 2]| (x.at(point[0]), y.at(point[1]));
    if series.dots {
        for (px, py) in series.points.iter().map(place).filter(|(px, py)| px.is_finite() && py.is_finite()) {
            writeln!(out, "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"1.4\" fill=\"{colour}\"/>")?;
        }
        return Ok(());
    }
    let mut path = String::new();
    let mut drawing = false;
    for (px, py) in series.points.iter().map(place) {
        if px.is_finite() && py.is_finite() {
            write!(path, "{}{px:.1} {py:.1}", if drawing { 'L' } else { 'M' })?;
            drawing = true;
        } else {
            drawing = false;
        }
    }
    let dash = if series.dashed { " stroke-dasharray=\"6 4\"" } else { "" };
    writeln!(out, "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.3\"{dash}/>")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<[f64; 2]>, log: bool) -> Chart {
        let series = Series { label: "<b>".into(), points, colour: BLUE, dots: false, dashed: true };
        Chart {
            title: "a & b".into(),
            x: "x".into(),
            y: "y".into(),
            log,
            square: false,
            series: vec![series],
        }
    }

    #[test]
    fn a_chart_is_drawn_with_gaps_and_its_words_are_text() {
        let svg =
            chart(vec![[0.0, 1.0], [1.0, 2.0], [2.0, f64::NAN], [3.0, 4.0]], false).svg().expect("points");
        assert!(svg.contains("a &amp; b") && svg.contains("&lt;b&gt;") && !svg.contains("<b>"));
        assert!(!svg.contains("NaN"));
        assert_eq!(svg.matches('M').count() - svg.matches("<path d=\"M").count(), 1, "one gap: {svg}");
        assert!(chart(vec![[1.0, 10.0], [100.0, 0.1]], true).svg().expect("points").contains("1e1"));
        assert!(chart(vec![[f64::NAN; 2]], false).svg().is_none());
        assert!(chart(vec![[1.0, 1.0]], false).svg().is_some());
    }
}
