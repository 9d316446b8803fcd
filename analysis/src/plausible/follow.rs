//! How well a gyro follows a vector that stands still in the world, in each of the 48 orders of its axes.
//!
//! A vector `m` of the body, `b` next to one that is fixed in the world, changes by `Δm = −k ∫ω×m dt + k ∫ω dt × b`: linear in
//! the gyro's scale `k` and in `k b`. Nothing need be calibrated for it.

use crate::plausible::orders::Order;
use crate::samples::series::median;
use nalgebra::{Matrix4, Vector3, Vector4};

/// A stretch of the log is long enough where the vector moves by this share of its size: some 20°.
const MOVES: f64 = 0.35;
/// … and a step from one reading to the next must be shorter than this: turned faster, the readings do not show how.
const MOST_A_STEP: f64 = 0.6;
/// Stretches of at most this many readings.
const LONGEST: usize = 512;
/// Below this share of its own, even the sign of the scale is a guess.
const SIGN_DETERMINED: f64 = 0.2;
/// Fewer stretches say nothing.
pub const LEAST: usize = 40;
/// More are not looked at.
const MOST: usize = 2000;

/// One order of the gyro's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// The order.
    pub order: Order,
    /// What the gyro's numbers must be multiplied by; negative only where little of it is determined.
    pub factor: f64,
    /// Share of the vector's changes that it explains.
    pub explained: f64,
    /// How much of what the scale does an offset cannot do as well: 1 without one, near 0 where the vector moved over too
    /// small a part of its sphere to tell them apart.
    pub determined: f64,
}

/// How a gyro follows a vector.
#[derive(Debug, Clone, PartialEq)]
pub struct Follow {
    /// Stretches of the log.
    pub stretches: usize,
    /// With its axes as they are.
    pub own: Fit,
    /// The order that explains most; `own` where that is as good.
    pub best: Fit,
    /// The others that explain as much.
    pub equal: Vec<Order>,
}

/// What is integrated over one stretch.
struct Stretch {
    change: Vector3<f64>,
    /// `∫ω_i m_j dt`.
    products: [[f64; 3]; 3],
    /// `∫ω dt`.
    turn: [f64; 3],
}

/// A gyro next to a vector, at the rows where the vector was read again. `spread` is the vector's size; `offset` says whether
/// it has one.
pub struct Pair<'a> {
    /// Time, s.
    pub time_s: &'a [f64],
    /// Rate of turn as read.
    pub rate: [&'a [f64]; 3],
    /// The vector.
    pub vector: [&'a [f64]; 3],
    /// Rows where it is new.
    pub rows: &'a [usize],
    /// Its size.
    pub size: f64,
    /// Whether an unknown offset stands next to it.
    pub offset: bool,
}

impl Pair<'_> {
    /// How the gyro follows the vector; `None` where too little turns, or too fast.
    pub fn follow(&self) -> Option<Follow> {
        let length = self.length()?;
        let stretches = self.stretches(length);
        if stretches.len() < LEAST {
            return None;
        }
        let fits: Vec<Fit> = Order::all().filter_map(|order| fit(&stretches, order, self.offset)).collect();
        let own = Fit { factor: f64::NAN, explained: 0.0, determined: 0.0, order: Order::all().next()? };
        let own = fits.iter().copied().find(|fit| fit.order.is_own()).unwrap_or(own);
        let most = fits.iter().copied().max_by(|a, b| a.explained.total_cmp(&b.explained))?;
        let best = if own.explained > most.explained - 0.05 { own } else { most };
        let equal =
            fits.iter().filter(|fit| fit.order != best.order && fit.explained > best.explained - 0.05);
        let equal = equal.map(|fit| fit.order).collect();
        Some(Follow { stretches: stretches.len(), own, best, equal })
    }

    fn at(&self, row: usize) -> Option<Vector3<f64>> {
        let cell = |axis: usize| self.vector[axis].get(row).copied().filter(|value| value.is_finite());
        Some(Vector3::new(cell(0)?, cell(1)?, cell(2)?))
    }

    /// How many readings a stretch has: the fewest over which the vector moves enough.
    fn length(&self) -> Option<usize> {
        let moved = |length: usize| {
            let count = self.rows.len().checked_sub(length)?;
            let stride = count.div_ceil(MOST).max(1);
            let mut all: Vec<f64> = (0..count)
                .step_by(stride)
                .filter_map(|i| {
                    Some((self.at(*self.rows.get(i + length)?)? - self.at(*self.rows.get(i)?)?).norm())
                })
                .collect();
            // The upper third: a log has rests.
            all.sort_by(f64::total_cmp);
            all.get(all.len() * 2 / 3).copied()
        };
        if moved(1)? > MOST_A_STEP * self.size {
            return None;
        }
        let mut length = 1;
        while length <= LONGEST {
            if moved(length)? >= MOVES * self.size {
                return Some(length);
            }
            length *= 2;
        }
        None
    }

    fn stretches(&self, length: usize) -> Vec<Stretch> {
        let count = self.rows.len() / length;
        let stride = count.div_ceil(MOST).max(1);
        (0..count)
            .step_by(stride)
            .filter_map(|k| self.stretch(self.rows.get(k * length..=(k + 1) * length)?))
            // At rest noise alone moves the vector.
            .filter(|stretch| stretch.change.norm() > 0.3 * MOVES * self.size)
            .collect()
    }

    /// The integrals by the trapezium rule, between the rows where the vector is new.
    fn stretch(&self, rows: &[usize]) -> Option<Stretch> {
        let (mut products, mut turn) = ([[0.0; 3]; 3], [0.0; 3]);
        let mut steps = Vec::with_capacity(rows.len());
        for pair in rows.windows(2) {
            let [from, to] = *pair else { return None };
            let (before, after) = (self.at(from)?, self.at(to)?);
            let seconds = self.time_s.get(to)? - self.time_s.get(from)?;
            steps.push(seconds);
            let angle = self.angle(from, to)?;
            let middle = (before + after) / 2.0;
            for i in 0..3 {
                turn[i] += angle[i];
                for j in 0..3 {
                    products[i][j] += angle[i] * middle[j];
                }
            }
        }
        // Over a gap nobody knows how it turned.
        let longest = steps.iter().copied().fold(0.0, f64::max);
        if steps.len() > 2 && longest > 20.0 * median(&mut steps).max(1e-12) && longest > 0.3 {
            return None;
        }
        let change = self.at(*rows.last()?)? - self.at(*rows.first()?)?;
        Some(Stretch { change, products, turn })
    }

    /// `∫ω dt` from one row to another.
    fn angle(&self, from: usize, to: usize) -> Option<[f64; 3]> {
        let mut angle = [0.0; 3];
        for row in from..to {
            let seconds = self.time_s.get(row + 1)? - self.time_s.get(row)?;
            for (angle, rate) in angle.iter_mut().zip(self.rate) {
                let mean = (rate.get(row)? + rate.get(row + 1)?) / 2.0;
                if !mean.is_finite() {
                    return None;
                }
                *angle += mean * seconds;
            }
        }
        Some(angle)
    }
}

/// Least squares of the changes on scale and offset, for one order; `None` where the scale is certainly negative.
fn fit(stretches: &[Stretch], order: Order, offset: bool) -> Option<Fit> {
    let (mut normal, mut right, mut squares) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
    for stretch in stretches {
        let s = |i: usize, j: usize| order.sign(i) * stretch.products[order.axis[i]][j];
        let w = Vector3::from_fn(|i, _| order.sign(i) * stretch.turn[order.axis[i]]);
        let crossed = Vector3::new(s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0));
        let beside = w.cross_matrix();
        for axis in 0..3 {
            let mut row = Vector4::new(-crossed[axis], 0.0, 0.0, 0.0);
            if offset {
                row.fixed_rows_mut::<3>(1).copy_from(&beside.row(axis).transpose());
            }
            normal += row * row.transpose();
            right += row * stretch.change[axis];
            squares += stretch.change[axis].powi(2);
        }
    }
    // Equal diagonals keep the digits whatever the units; what no stretch shows is held at zero.
    let scale =
        Vector4::from_fn(|i, _| if normal[(i, i)] > 0.0 { normal[(i, i)].sqrt().recip() } else { 0.0 });
    let unit = Matrix4::from_fn(|i, j| {
        let value = normal[(i, j)] * scale[i] * scale[j];
        if i == j { value + 1e-9 + if scale[i] == 0.0 { 1.0 } else { 0.0 } } else { value }
    });
    let solution = unit.cholesky()?.solve(&right.component_mul(&scale));
    let explained = solution.dot(&right.component_mul(&scale)) / squares;
    let factor = solution[0] * scale[0];
    // What is left of the scale's column next to the offset's, of a diagonal of 1.
    let determined = unit.try_inverse().map_or(0.0, |inverse| inverse[(0, 0)].recip());
    // Where the offset does nearly as well, the sign of the scale says nothing.
    let signed = factor > 0.0 || (offset && determined < SIGN_DETERMINED);
    (signed && explained.is_finite()).then_some(Fit { order, factor, explained, determined })
}
