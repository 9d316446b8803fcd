//! Place, times, noise level and the other sensors of a log.

use crate::kind::Kind;
use crate::linalg::{Quat, Vec3, dot, quat_from_vector, quat_mul, scale};
use crate::noise::{Colour, ar1};
use crate::random::{Source, chance, choose, direction, log_uniform, sign, uniform};

/// Places: latitude and longitude in degrees, field in µT, dip and declination in degrees (world magnetic model
/// 2025 at mid-2025).
const PLACES: [[f64; 5]; 9] = [
    [47.37, 8.54, 48.34, 63.49, 3.48],
    [40.71, -74.01, 50.89, 65.65, -12.51],
    [35.68, 139.69, 46.85, 49.52, -7.89],
    [-33.87, 151.21, 57.0, -64.39, 12.8],
    [-1.29, 36.82, 33.49, -22.54, 0.34],
    [1.35, 103.82, 42.1, -12.89, 0.2],
    [-33.92, 18.42, 25.04, -64.78, -26.5],
    [61.22, -149.9, 54.99, 73.98, 14.34],
    [64.15, -21.94, 52.57, 75.44, -11.43],
];

/// Magnetic field at the place of the log.
pub struct Place {
    pub field_ut: f64,
    pub dip_deg: f64,
    pub declination_deg: f64,
    pub field_ned: Vec3,
    /// Latitude and longitude in degrees, where the log tells them.
    pub position: Option<[f64; 2]>,
}

impl Place {
    pub fn draw(rng: &mut Source, kind: Kind) -> Place {
        let (position, field_ut, dip_deg, declination_deg);
        if chance(rng, if kind.is_confined() { 0.5 } else { 0.1 }) {
            let [latitude, longitude, field, dip, declination] = choose(rng, &PLACES);
            position = Some([latitude, longitude]);
            // Rocks and buildings make the field of a place differ from the model's.
            field_ut = field * uniform(rng, 0.995, 1.005);
            dip_deg = dip + uniform(rng, -0.4, 0.4);
            declination_deg = declination + uniform(rng, -0.4, 0.4);
        } else {
            position = None;
            field_ut = uniform(rng, 25.0, 65.0);
            dip_deg = sign(rng) * uniform(rng, 15.0, 75.0);
            declination_deg = uniform(rng, -20.0, 20.0);
        }
        let (dip, declination) = (dip_deg.to_radians(), declination_deg.to_radians());
        let north_east = [declination.cos() * dip.cos(), declination.sin() * dip.cos()];
        let field_ned = scale(field_ut, [north_east[0], north_east[1], dip.sin()]);
        Place { field_ut, dip_deg, declination_deg, field_ned, position }
    }
}

/// Level, colour and quantisation of the magnetometer's noise.
pub struct Level {
    pub colour: Colour,
    pub sigma_ut: Vec3,
    pub lsb_ut: f64,
}

impl Level {
    pub fn draw(kind: Kind, rng: &mut Source) -> Level {
        let colour = match kind {
            Kind::NothingColoured => choose(rng, &Colour::COLOURED),
            Kind::Coloured => Colour::OneOverF,
            kind if kind.is_confined() && chance(rng, 0.4) => choose(rng, &Colour::COLOURED),
            _ => Colour::White,
        };
        let sigma = log_uniform(rng, 0.08, if kind == Kind::Strong { 0.25 } else { 0.8 });
        let spread = if chance(rng, 0.3) { 0.15 } else { 0.0 };
        let sigma_ut = std::array::from_fn(|_| sigma * (1.0 + spread * uniform(rng, -1.0, 1.0)));
        let lsb_ut = match colour {
            Colour::Quantised => sigma * uniform(rng, 3.0, 5.0),
            _ if chance(rng, 0.25) => sigma * log_uniform(rng, 0.1, 1.5),
            _ => 0.0,
        };
        Level { colour, sigma_ut, lsb_ut }
    }

    pub fn noise_ut(&self) -> f64 {
        (dot(self.sigma_ut, self.sigma_ut) / 3.0 + self.lsb_ut * self.lsb_ut / 12.0).sqrt()
    }
}

/// Accelerometer and gyro next to the magnetometer.
pub struct Imu {
    pub accelerometer: bool,
    pub gyro: bool,
    pub accel_bias: Vec3,
    pub accel_sigma: f64,
    pub gyro_bias: Vec3,
    pub gyro_sigma: f64,
}

impl Imu {
    pub fn draw(rng: &mut Source, kind: Kind, needed: bool) -> Imu {
        let accelerometer = chance(rng, 0.75) || needed || kind.is_confined();
        let gyro = accelerometer && chance(rng, 0.8) || needed || kind.is_confined();
        Imu {
            accelerometer,
            gyro,
            accel_bias: scale(log_uniform(rng, 0.01, 0.15), direction(rng)),
            accel_sigma: log_uniform(rng, 0.02, 0.1),
            gyro_bias: scale(log_uniform(rng, 0.002, 0.03), direction(rng)),
            gyro_sigma: log_uniform(rng, 0.001, 0.005),
        }
    }
}

/// Times in s, in whole microseconds, and the nominal rate in Hz.
pub fn times(kind: Kind, rng: &mut Source) -> (Vec<f64>, f64) {
    let rate_hz = if chance(rng, 0.6) {
        choose(rng, &[10.0, 20.0, 25.0, 50.0, 100.0])
    } else {
        log_uniform(rng, 10.0, 100.0)
    };
    let length = match kind {
        Kind::Quick => 15.0,
        kind if kind.is_confined() || kind.is_well_covered() => log_uniform(rng, 60.0, 400.0),
        _ => log_uniform(rng, 30.0, 600.0),
    };
    // Longer logs at high rates would only cost time.
    let n = ((length * rate_hz) as usize).min(24_000);
    let jitter = if chance(rng, 0.3) { uniform(rng, 0.02, 0.3) } else { 0.0 };
    let time = |i: usize| {
        let t = (i as f64 + 0.5 + jitter * uniform(rng, -1.0, 1.0)) / rate_hz;
        (t * 1e6).round() / 1e6
    };
    ((0..n).map(time).collect(), rate_hz)
}

/// Orientation as an autopilot estimates it: wrong by a slowly varying degree in tilt and two in heading.
pub fn estimated_attitude(rng: &mut Source, attitude: &[Quat], rate_hz: f64) -> Vec<Quat> {
    let memory = log_uniform(rng, 4.0, 40.0) * rate_hz;
    let sizes = [uniform(rng, 0.2, 1.0), uniform(rng, 0.2, 1.0), uniform(rng, 0.7, 2.5)].map(f64::to_radians);
    let errors: [Vec<f64>; 3] = std::array::from_fn(|k| {
        let raw = ar1(rng, attitude.len(), memory);
        // A filter's error has no jumps from sample to sample: smooth the walk.
        let mut state = raw[0];
        raw.iter()
            .map(|v| {
                state += (v - state) / (0.2 * rate_hz).max(1.0);
                sizes[k] * state
            })
            .collect()
    });
    let turn =
        |(i, &q): (usize, &Quat)| quat_mul(quat_from_vector([errors[0][i], errors[1][i], errors[2][i]]), q);
    attitude.iter().enumerate().map(turn).collect()
}
