//! Causes outside of the catalogue of effects.

use crate::column::{Column, Signal};
use crate::effect::{Scene, Shape};
use crate::linalg::{Vec3, add_scaled, mul_vec, norm, standardised};
use crate::random::{Source, chance, choose, direction, log_uniform, normal3, uniform};

/// Shape outside of the catalogue, and the columns that belong to it.
pub struct Beyond {
    pub shape: Shape,
    pub columns: Vec<Column>,
}

impl Scene<'_> {
    /// Cause outside of the catalogue, number `which` of nine, with its columns.
    pub fn beyond(
        &self,
        which: usize,
        rng: &mut Source,
        draw: &mut dyn FnMut(&mut Source, &str) -> Column,
    ) -> Beyond {
        let last = self.times[self.times.len() - 1];
        let mut parameters = Vec::new();
        let vector = direction(rng);
        let constant = |course: &[f64]| self.along(vector, &standardised(course));
        let (id, words, columns, unit): (String, String, Vec<Column>, Vec<Vec3>);
        match which {
            0 => {
                let name = choose(rng, &["temp_c", "current_a"]);
                let column = draw(rng, name);
                let tau_s = log_uniform(rng, 1.0, 100.0_f64.min(last / 2.0));
                parameters.push(("tau_s", tau_s));
                unit = constant(&column.signal.low_pass(tau_s).sample(self.times));
                (id, words) =
                    (format!("offset:{name}~{tau_s:.2}"), format!("low-pass of {name}, tau {tau_s:.2} s"));
                columns = vec![column];
            }
            1 => {
                let current = draw(rng, "current_a");
                let other = choose(rng, &["temp_c", "fan_rpm"]);
                let pair = [current, draw(rng, other)];
                let mut values = pair.each_ref().map(|c| c.signal.sample(self.times));
                // A plain product is largely a sum of the two; one of centred columns is not.
                let centred = chance(rng, 0.5);
                if centred {
                    values = values.map(|v| standardised(&v));
                }
                unit = constant(&values[0].iter().zip(&values[1]).map(|(a, b)| a * b).collect::<Vec<f64>>());
                id = format!("offset:{}*{}", pair[0].name, pair[1].name);
                let about = if centred { "their means" } else { "zero" };
                words = format!("product of {} and {} about {about}", pair[0].name, pair[1].name);
                columns = pair.into();
            }
            2 => {
                let name = choose(rng, &["current_a", "throttle"]);
                let column = draw(rng, name);
                let power = |v: f64| v.max(0.0).powf(1.5);
                unit =
                    constant(&column.signal.sample(self.times).into_iter().map(power).collect::<Vec<f64>>());
                (id, words) =
                    (format!("offset:{}", column.name), format!("{} to the power 1.5", column.name));
                columns = vec![column];
            }
            3 => {
                let column = draw(rng, "current_a");
                let mut sorted = column.signal.sample(self.times);
                let values = sorted.clone();
                sorted.sort_by(f64::total_cmp);
                let knee = sorted[(sorted.len() as f64 * uniform(rng, 0.3, 0.6)) as usize].max(0.1);
                unit = constant(&values.iter().map(|v| (v / knee).tanh()).collect::<Vec<f64>>());
                (id, words) =
                    ("offset:current_a".into(), format!("saturation: tanh of current_a / {knee:.2} A"));
                columns = vec![column];
            }
            4 => {
                let column = draw(rng, "temp_c");
                let axis = choose(rng, &[0, 1, 2]);
                let mut gain = [0.0; 3];
                gain[axis] = 1.0;
                // Only what comes through the coil of the axis: the field, not the offset of the electronics.
                let course = standardised(&column.signal.sample(self.times));
                let at = |(i, z): (usize, &f64)| {
                    let x = mul_vec(&self.matrix, self.seen[i]);
                    std::array::from_fn(|k| gain[k] * x[k] * z / norm(self.field_ned))
                };
                unit = course.iter().enumerate().map(at).collect();
                let letter = ["x", "y", "z"][axis];
                (id, words) = (
                    "gain:temp_c".into(),
                    format!("gain of the {letter} axis alone with temp_c, not of the offset"),
                );
                columns = vec![column];
            }
            5 => {
                let hold = last / uniform(rng, 6.0, 40.0);
                let (mut on, mut next) = (false, uniform(rng, 0.0, hold));
                let state = |&t: &f64| {
                    while t >= next {
                        on = !on;
                        next += hold * uniform(rng, 0.3, 2.0);
                    }
                    f64::from(on)
                };
                let states: Vec<f64> = self.times.iter().map(state).collect();
                unit = self.along(vector, &states);
                (id, words) = ("switch".into(), "unlogged part that is switched on and off".into());
                columns = Vec::new();
            }
            6 => {
                let count = choose(rng, &[2, 3, 4, 5, 6]);
                let steps: Vec<(f64, Vec3)> = (0..count)
                    .map(|k| {
                        (last * (k as f64 + uniform(rng, 0.6, 1.3)) / (count as f64 + 0.8), normal3(rng))
                    })
                    .collect();
                let level = |&t: &f64| {
                    let past = steps.iter().filter(|(at, _)| t >= *at);
                    past.fold([0.0; 3], |sum, (_, size)| add_scaled(sum, 1.0, *size))
                };
                unit = self.times.iter().map(level).collect();
                let at: Vec<String> = steps.iter().map(|(at, _)| format!("{at:.2}")).collect();
                (id, words) = ("step".into(), format!("{count} offset steps at {} s", at.join(", ")));
                columns = Vec::new();
            }
            7 => {
                let common = draw(rng, "throttle");
                let mut motors = Vec::new();
                let mut sum = vec![[0.0; 3]; self.times.len()];
                for motor in 1..=4 {
                    let own = draw(rng, "current_a");
                    let mixed = Signal::from_fn(last, |t| {
                        (1.0 + 8.0 * common.signal.at(t) + 0.2 * (own.signal.at(t) - 9.0)).max(0.0)
                    });
                    let centre = standardised(&mixed.sample(self.times));
                    let vector = direction(rng);
                    sum.iter_mut().zip(&centre).for_each(|(s, z)| *s = add_scaled(*s, *z, vector));
                    motors.push(Column::new(&format!("esc{motor}_a"), mixed, 0.03, 0.01));
                }
                unit = sum;
                id = "offset:esc1_a+esc2_a+esc3_a+esc4_a".into();
                words = "four motor currents, each with its own vector".into();
                columns = motors;
            }
            _ => {
                let name = choose(rng, &["current_a", "throttle"]);
                let mut column = draw(rng, name);
                column.late_s = uniform(rng, 0.1, 0.5);
                parameters.push(("delay_s", -column.late_s));
                unit = constant(&column.signal.sample(self.times));
                id = format!("offset:{}@{:.3}", column.name, -column.late_s);
                words = format!(
                    "offset proportional to {}, which is logged {:.3} s late",
                    column.name, column.late_s
                );
                columns = vec![column];
            }
        }
        let names = columns.iter().map(|c| c.name.clone()).collect();
        Beyond { shape: Shape { id, words, in_catalogue: false, parameters, columns: names, unit }, columns }
    }
}
