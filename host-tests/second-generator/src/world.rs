//! One log put together: place, motion, sensor, effects, columns and noise.

use crate::column::{self, Column, Quantity};
use crate::effect::{Family, Scene, sensor};
use crate::kind::Kind;
use crate::linalg::{Quat, Vec3, add_scaled, dot, mul_vec, norm, rms, to_body};
use crate::motion::{Motion, Style};
use crate::random::{Source, chance, choose, log_uniform, normal3, shuffle, source, uniform};
use crate::setting::{Imu, Level, Place, estimated_attitude, times};
use crate::truth::{Hidden, Truth};
use std::fmt::Write;

/// Draws of a whole log before one whose strengths miss their limits is taken.
const MOST_TRIES: usize = 30;

/// Log and truth.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Columns by the names of the log's contract, in µT, m/s², rad/s and the units of the names. A NaN is an
    /// empty cell.
    pub columns: Vec<(String, Vec<f64>)>,
    /// What the log hides.
    pub truth: Truth,
}

impl Drawn {
    /// Column by its name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
    }

    /// The log as CSV with a header; six decimals.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut out = names.join(",") + "\n";
        for row in 0..self.columns.first().map_or(0, |(_, values)| values.len()) {
            for (k, (_, values)) in self.columns.iter().enumerate() {
                if k > 0 {
                    out.push(',');
                }
                if values[row].is_finite() {
                    // Writing into a string cannot fail.
                    let _ = write!(out, "{:.6}", values[row]);
                }
            }
            out.push('\n');
        }
        out
    }
}

/// Log of a kind and a number: always the same for the same two.
pub fn draw(kind: Kind, number: u64) -> Drawn {
    let mut rng = source(kind.name(), number);
    let [least, most] = kind.strengths();
    let mut drawn = try_draw(kind, number, &mut rng);
    for _ in 1..MOST_TRIES {
        let within = |h: &Hidden| h.strength > 0.999 * least && h.strength < 1.001 * most;
        if drawn.truth.hidden.iter().all(within) {
            break;
        }
        drawn = try_draw(kind, number, &mut rng);
    }
    drawn
}

fn try_draw(kind: Kind, number: u64, rng: &mut Source) -> Drawn {
    let families = families(kind, rng);
    let place = Place::draw(rng, kind);
    let (times, rate_hz) = times(kind, rng);
    let length = times[times.len() - 1];
    let (style, motion) =
        covering_motion(kind, families.contains(&Family::Lag), rng, length, place.field_ned);
    let attitude: Vec<Quat> = times.iter().map(|&t| motion.orientation(t)).collect();
    let field_body_ut: Vec<Vec3> = attitude.iter().map(|&q| to_body(q, place.field_ned)).collect();

    let most_offset = if kind.is_well_covered() { 1.0 } else { 1.5 };
    let (matrix, offset_ut) = sensor(rng, place.field_ut, most_offset);
    let level = Level::draw(kind, rng);
    let mut scene =
        Scene::new(&times, rate_hz, place.field_ned, (matrix, offset_ut), level.noise_ut(), &motion);

    let mut hidden = Vec::new();
    let mut causes: Vec<Column> = Vec::new();
    let mut logged_too: Vec<Column> = Vec::new();
    let flight = Column::of_flight(rng, &motion, length);
    if kind == Kind::Flight {
        // A drone logs its throttle and its current whether or not they disturb.
        let (throttle, current) = flight.clone().expect("a flight has thrust");
        logged_too.push(throttle);
        if families.is_empty() {
            logged_too.push(current);
        }
    }
    let [least, most] = kind.strengths();
    for family in families {
        let strength = log_uniform(rng, least, most);
        if family == Family::Lag {
            hidden.push(scene.lag(strength));
            continue;
        }
        let column = family.needs_column().then(|| {
            let used: Vec<&str> = causes.iter().chain(&logged_too).map(|c| c.name.as_str()).collect();
            let quantity = cause(kind, family, rng, &used);
            draw_column(rng, quantity, length, flight.as_ref())
        });
        hidden.push(scene.scaled(scene.shape(family, rng, column.as_ref()), strength));
        causes.extend(column);
    }
    if kind == Kind::Beyond {
        let which = choose(rng, &[0, 1, 2, 3, 4, 5, 6, 7, 8]);
        let mut by_name = |rng: &mut Source, name: &str| {
            let all = [column::TEMPERATURE, column::CURRENT, column::THROTTLE, column::FAN];
            let quantity = all.into_iter().find(|q| q.name == name).unwrap_or(column::CURRENT);
            Column::draw(rng, quantity, length)
        };
        let beyond = scene.beyond(which, rng, &mut by_name);
        let strength = log_uniform(rng, least, most);
        hidden.push(scene.scaled(beyond.shape, strength));
        causes.extend(beyond.columns);
    }

    let mut extra: Vec<(String, Vec<f64>)> = Vec::new();
    if kind == Kind::Alike {
        let correlation = uniform(rng, 0.97, 0.995);
        extra.push((twin_name(&causes[0].name).into(), column::twin(rng, &causes[0], correlation, &times)));
    }
    if kind == Kind::Gaps {
        causes[0].every_s = uniform(rng, 1.5, 8.0) / rate_hz.min(20.0);
        for _ in 0..choose(rng, &[1, 2, 3]) {
            let (from, share) = (length * uniform(rng, 0.0, 0.9), uniform(rng, 0.02, 0.07));
            causes[0].gaps.push([from, from + share * length]);
        }
    }
    let mut used: Vec<String> = causes.iter().chain(&logged_too).map(|c| c.name.clone()).collect();
    used.extend(extra.iter().map(|(name, _)| name.clone()));
    let count = choose(rng, &[1, 2, 3, 4]);
    logged_too.extend(column::decoys(rng, &used, count, length));
    let decoys =
        logged_too.iter().map(|c| c.name.clone()).chain(extra.iter().map(|(n, _)| n.clone())).collect();
    if kind == Kind::Deleted {
        hidden.iter_mut().for_each(|h| h.logged = false);
        causes.clear();
    }
    causes.extend(logged_too);
    extra.extend(causes.iter().map(|c| (c.name.clone(), c.cells(rng, &times))));
    // The order must not tell which column is a cause.
    shuffle(rng, &mut extra);

    let (noise, colour_words) = level.colour.draw(rng, times.len(), rate_hz);
    let mut columns = vec![("t_s".to_string(), times.clone())];
    for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
        let reading = |i: usize| {
            let clean = mul_vec(&matrix, field_body_ut[i])[axis] + offset_ut[axis];
            let disturbance: f64 = hidden.iter().map(|h| h.disturbance_ut[i][axis]).sum();
            let reading = clean + disturbance + level.sigma_ut[axis] * noise[axis][i];
            if level.lsb_ut > 0.0 { (reading / level.lsb_ut).round() * level.lsb_ut } else { reading }
        };
        columns.push((format!("m{letter}_ut"), (0..times.len()).map(reading).collect()));
    }

    let imu = Imu::draw(rng, kind, hidden.iter().any(|h| h.id == "lag"));
    let mut accel_tilt_rms_deg = f64::NAN;
    if imu.accelerometer {
        let force: Vec<Vec3> = motion
            .specific_force(&times)
            .into_iter()
            .map(|f| add_scaled(add_scaled(f, 1.0, imu.accel_bias), imu.accel_sigma, normal3(rng)))
            .collect();
        let tilt = |(&q, &f): (&Quat, &Vec3)| {
            let down = to_body(q, [0.0, 0.0, 1.0]);
            (-dot(down, f) / norm(f)).clamp(-1.0, 1.0).acos().to_degrees()
        };
        accel_tilt_rms_deg = rms(&attitude.iter().zip(&force).map(tilt).collect::<Vec<f64>>());
        push_vectors(&mut columns, "a", "mps2", &force);
    }
    if imu.gyro {
        let rate = |&t: &f64| {
            let biased = add_scaled(motion.angular_rate(t), 1.0, imu.gyro_bias);
            add_scaled(biased, imu.gyro_sigma, normal3(rng))
        };
        let rates: Vec<Vec3> = times.iter().map(rate).collect();
        push_vectors(&mut columns, "g", "radps", &rates);
    }
    if kind.is_confined() {
        let estimated = estimated_attitude(rng, &attitude, rate_hz);
        for (k, name) in ["q_w", "q_x", "q_y", "q_z"].iter().enumerate() {
            columns.push((name.to_string(), estimated.iter().map(|q| q[k]).collect()));
        }
    }
    columns.extend(extra);
    if let Some([latitude, longitude]) = place.position {
        columns.push(("lat_deg".into(), vec![latitude; times.len()]));
        columns.push(("lon_deg".into(), vec![longitude; times.len()]));
    }

    let truth = Truth {
        kind: kind.name().into(),
        number,
        hidden,
        decoys,
        motion: format!("{style:?}"),
        coverage: coverage(&field_body_ut),
        field_ut: place.field_ut,
        dip_deg: place.dip_deg,
        declination_deg: place.declination_deg,
        offset_ut,
        matrix,
        sigma_ut: level.sigma_ut,
        noise_ut: level.noise_ut(),
        noise: colour_words,
        lsb_ut: level.lsb_ut,
        rate_hz,
        gyro_bias_radps: imu.gyro_bias,
        accel_bias_mps2: imu.accel_bias,
        accel_tilt_rms_deg,
        field_body_ut,
        attitude,
    };
    Drawn { columns, truth }
}

/// Families of the hidden effects; a lag comes first, since the others act on what the sensor sees.
fn families(kind: Kind, rng: &mut Source) -> Vec<Family> {
    use Family::{CrossAxis, Field, Gain, Lag, Nonlinearity, Offset};
    let count = match kind {
        Kind::One | Kind::Strong => 1,
        Kind::Two => 2,
        Kind::Three => 3,
        _ => 0,
    };
    match kind {
        Kind::Deleted | Kind::Gaps => vec![choose(rng, &[Offset, Offset, Gain, Field])],
        Kind::Alike => vec![choose(rng, &[Offset, Offset, Gain])],
        Kind::PlainOffset => vec![Offset],
        Kind::Gain => vec![Gain],
        Kind::Lag => vec![Lag],
        Kind::Shape => vec![choose(rng, &[Nonlinearity, CrossAxis])],
        Kind::Flight if chance(rng, 0.5) => vec![Offset],
        _ => {
            let mut all = Family::ALL;
            shuffle(rng, &mut all);
            let mut chosen = all[..count].to_vec();
            chosen.sort_by_key(|&family| family != Lag);
            chosen
        }
    }
}

/// Quantity that drives a family, none of those in use.
fn cause(kind: Kind, family: Family, rng: &mut Source, used: &[&str]) -> Quantity {
    if kind == Kind::Flight {
        return column::CURRENT;
    }
    let list: &[Quantity] = match family {
        Family::Gain => &column::FOR_GAIN,
        Family::Field => &column::FOR_FIELD,
        _ => &column::FOR_OFFSET,
    };
    let free: Vec<Quantity> = list.iter().copied().filter(|q| !used.contains(&q.name)).collect();
    choose(rng, &free)
}

/// Column of a quantity; a drone's throttle and current follow its thrust.
fn draw_column(
    rng: &mut Source,
    quantity: Quantity,
    length: f64,
    flight: Option<&(Column, Column)>,
) -> Column {
    match flight {
        Some((throttle, _)) if quantity.name == throttle.name => throttle.clone(),
        Some((_, current)) if quantity.name == current.name => current.clone(),
        _ => Column::draw(rng, quantity, length),
    }
}

/// Name for a second column of the same sort.
fn twin_name(name: &str) -> &'static str {
    match name {
        "temp_c" => "board_c",
        "current_a" => "supply_a",
        "throttle" => "throttle_command",
        "voltage_v" => "rail_v",
        "fan_rpm" => "fan2_rpm",
        "servo_deg" => "servo_command_deg",
        "pump_a" => "pump2_a",
        _ => "coil2_a",
    }
}

/// Motion that turns the field through enough directions, or the best of several.
fn covering_motion(
    kind: Kind,
    with_lag: bool,
    rng: &mut Source,
    length: f64,
    field_ned: Vec3,
) -> (Style, Motion) {
    let styles: &[Style] = match kind {
        Kind::Flight => &[Style::Flight],
        Kind::Car => &[Style::Car],
        Kind::Boat => &[Style::Boat],
        Kind::Quick => &[Style::HastyHand],
        // In aerobatics an accelerometer feels the thrust alone: no dip could show a lag.
        _ if with_lag => &[Style::FigureEight, Style::Tumble, Style::JerkyHand, Style::TwoAxisMachine],
        _ => &[Style::FigureEight, Style::Tumble, Style::JerkyHand, Style::TwoAxisMachine, Style::Aerobatic],
    };
    let wanted = match kind {
        kind if kind.is_confined() => 0.0,
        kind if kind.is_well_covered() => 0.85,
        _ => 0.6,
    };
    let style = choose(rng, styles);
    let mut best = None;
    let mut best_coverage = -1.0;
    for _ in 0..20 {
        let motion = Motion::draw(style, rng, length);
        let directions: Vec<Vec3> = (0..1500)
            .map(|i| to_body(motion.orientation(length * f64::from(i) / 1500.0), field_ned))
            .collect();
        let covered = coverage(&directions);
        if covered > best_coverage {
            best_coverage = covered;
            best = Some(motion);
        }
        if best_coverage >= wanted {
            break;
        }
    }
    (style, best.expect("twenty motions were drawn"))
}

/// Share of 96 equal areas of the sphere (8 zones of 12 sectors) that the vectors' directions visit.
fn coverage(vectors: &[Vec3]) -> f64 {
    let mut visited = [false; 96];
    for v in vectors {
        let zone = ((0.5 + 0.5 * v[2] / norm(*v)) * 8.0).min(7.0) as usize;
        let sector = ((0.5 + v[1].atan2(v[0]) / std::f64::consts::TAU) * 12.0).min(11.0) as usize;
        visited[12 * zone + sector] = true;
    }
    visited.iter().filter(|&&v| v).count() as f64 / 96.0
}

fn push_vectors(columns: &mut Vec<(String, Vec<f64>)>, letter: &str, unit: &str, vectors: &[Vec3]) {
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        columns.push((format!("{letter}{name}_{unit}"), vectors.iter().map(|v| v[axis]).collect()));
    }
}
