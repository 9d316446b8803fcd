//! The summary as one page, to be read in a browser offline.

use crate::chart::{BLUE, Chart, GREEN, ORANGE, Series, escaped};
use crate::commands::batch::words::{APART, EFFECTS, apart, history, share, title, verdict};
use ironout_analysis::fleet::Fleet;
use ironout_analysis::fleet::history::{History, HistoryPoint};

/// Sensors whose offsets do not move are drawn up to this many.
const MAX_STILL_CHARTS: usize = 24;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#1a1a1a}\
table{border-collapse:collapse;margin:.5rem 0}td,th{padding:.2rem .8rem .2rem 0;text-align:left;border-bottom:1px solid #ddd}\
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem}\
.charts{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(27rem,100%),1fr));gap:1rem}svg{width:100%;height:auto}p.said{margin:.4rem 0;overflow-wrap:anywhere}\
@media(prefers-color-scheme:dark){body{background:#14161a;color:#eceef2}td,th{border-color:#3b414c}svg{filter:invert(.9) hue-rotate(180deg)}}";

/// The page of a fleet.
pub(super) fn html(fleet: &Fleet) -> String {
    let title = title(fleet);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\
         <meta name=\"viewport\" content=\"width=device-width\"><style>{STYLE}</style></head><body>\n<h1>{title}</h1>\n"
    );
    out += "<h2>Verdicts</h2>\n";
    let verdicts = fleet.verdicts.iter().map(|count| {
        [verdict(&count.what), count.logs.to_string(), format!("{:.1} %", share(count.logs, fleet.logs))]
    });
    out += &table(["Verdict", "Logs", "Share"], verdicts);
    out += &format!("<h2>{EFFECTS}</h2>\n");
    let effects = fleet
        .effects
        .iter()
        .map(|count| [count.what.clone(), count.logs.to_string(), count.vehicles.to_string()]);
    out += &table(["Effect", "Logs", "Vehicles"], effects);
    out += &format!("<h2>{APART}</h2>\n");
    out += &lines(&apart(fleet));
    out += "<h2>Offset over time</h2>\n";
    let (moved, still): (Vec<&History>, Vec<&History>) =
        fleet.sensors.iter().partition(|one| one.drift.is_some() || one.change.is_some());
    out += &lines(&moved.iter().map(|one| history(one)).collect::<Vec<_>>());
    out += &charts(&moved);
    out += &format!("<h2>Sensors without a significant change ({})</h2>\n", still.len());
    let shown = &still[..still.len().min(MAX_STILL_CHARTS)];
    out += &charts(shown);
    if shown.len() < still.len() {
        out += &format!("<p>The first {} are drawn; the table of the logs has all.</p>\n", shown.len());
    }
    out + "</body></html>\n"
}

fn table(head: [&str; 3], rows: impl Iterator<Item = [String; 3]>) -> String {
    let body: String = rows
        .map(|[what, first, second]| {
            format!(
                "<tr><td>{}</td><td class=\"n\">{first}</td><td class=\"n\">{second}</td></tr>\n",
                escaped(&what)
            )
        })
        .collect();
    if body.is_empty() {
        return "<p>none</p>\n".into();
    }
    let [what, first, second] = head;
    format!(
        "<table><tr><th>{what}</th><th class=\"n\">{first}</th><th class=\"n\">{second}</th></tr>\n{body}</table>\n"
    )
}

fn lines(lines: &[String]) -> String {
    if lines.is_empty() {
        return "<p>none</p>\n".into();
    }
    lines.iter().map(|line| format!("<p class=\"said\">{}</p>\n", escaped(line))).collect()
}

fn charts(sensors: &[&History]) -> String {
    let drawn: String = sensors.iter().filter_map(|one| chart(one)).collect();
    format!("<div class=\"charts\">{drawn}</div>\n")
}

/// The offset of one sensor, less its mean, over days.
fn chart(sensor: &History) -> Option<String> {
    let first = sensor.series.first()?.day;
    let series =
        [("x", BLUE), ("y", ORANGE), ("z", GREEN)].into_iter().enumerate().map(|(axis, (label, colour))| {
            let offset = |one: &HistoryPoint| one.offset_ut[axis] - sensor.offset_ut[axis];
            let points = sensor.series.iter().map(|one| [one.day - first, offset(one)]).collect();
            Series { label: label.into(), points, colour, dots: false, dashed: false }
        });
    let name = [sensor.vehicle.as_str(), sensor.sensor.as_str()];
    let name: Vec<&str> = name.into_iter().filter(|part| !part.is_empty()).collect();
    let chart = Chart {
        title: name.join(", "),
        x: "days since the first log".into(),
        y: "offset minus its mean, µT".into(),
        log: false,
        square: false,
        series: series.collect(),
    };
    chart.svg()
}
