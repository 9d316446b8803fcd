//! Sampling a world into a log.

use super::{GRAVITY_MPS2, HiddenEffect, World};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::io::{self, Write};

/// What only the simulator knows about a log.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Hard iron, µT.
    pub hard_iron_ut: [f64; 3],
    /// Rows of the soft-iron matrix.
    pub soft_iron: [[f64; 3]; 3],
    /// Magnitude of the field, µT.
    pub field_ut: f64,
    /// Standard deviation of the noise on each axis with the quantisation's share, µT.
    pub noise_ut: f64,
    /// The hidden effects.
    pub effects: Vec<HiddenEffect>,
    /// True field in the body frame, one a row, before any fault that removes rows.
    pub body_field_ut: Vec<[f64; 3]>,
}

/// A log: named columns of equal length. A missing cell is NaN.
#[derive(Clone, Debug)]
pub struct Log {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Values, by column.
    pub columns: Vec<Vec<f64>>,
    /// The truth behind them.
    pub truth: Truth,
}

impl Log {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Where a column stands.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|column| column == name)
    }

    /// A column by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.position(name).map(|index| self.columns[index].as_slice())
    }

    /// Names and values, column by column.
    pub fn named(&self) -> impl Iterator<Item = (&str, &[f64])> {
        self.names.iter().map(String::as_str).zip(self.columns.iter().map(Vec::as_slice))
    }

    /// Writes the log as CSV: a `#` line that names the source, a header, one line a row.
    pub fn write_csv(&self, mut out: impl Write, comment: &str) -> io::Result<()> {
        for line in comment.lines() {
            writeln!(out, "# {line}")?;
        }
        writeln!(out, "{}", self.names.join(","))?;
        for row in 0..self.rows() {
            for (index, column) in self.columns.iter().enumerate() {
                let value = column[row];
                if index > 0 {
                    write!(out, ",")?;
                }
                if value.is_finite() {
                    write!(out, "{value:.5}")?;
                }
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

impl World {
    /// Names of the covariates in the log: the usual three, and those that a hidden effect follows.
    fn covariate_names(&self) -> Vec<String> {
        let mut names: Vec<String> = ["temp_c", "current_a", "height_m"].map(String::from).to_vec();
        for spec in &self.options.effects {
            if let Some(column) = spec.column()
                && !names.iter().any(|name| name == column)
            {
                names.push(column.to_string());
            }
        }
        names
    }

    /// Samples the world into a log with every column, adds the sensors' noise and quantisation, then the faults.
    pub fn run(&self) -> Log {
        let options = &self.options;
        // Not the stream that drew the world: the noise must not depend on how many numbers that took.
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed ^ 0x6e6f_6973_655f_7574);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let mut names: Vec<String> =
            ["t_s", "mx_ut", "my_ut", "mz_ut", "ax_mps2", "ay_mps2", "az_mps2"].map(String::from).to_vec();
        names.extend(["gx_radps", "gy_radps", "gz_radps"].map(String::from));
        let covariates = self.covariate_names();
        names.extend(covariates.iter().cloned());
        names.push("heading_deg".into());
        let rows = (options.seconds * options.rate_hz).round().max(0.0) as usize;
        let mut columns = vec![Vec::with_capacity(rows); names.len()];
        let mut body_field_ut = Vec::with_capacity(rows);
        let rho = options.noise_correlation.clamp(0.0, 0.999);
        let mut noise = Vector3::from_fn(|_, _| normal()) * options.noise_ut;
        for row in 0..rows {
            let t = row as f64 / options.rate_hz;
            let fresh = Vector3::from_fn(|_, _| normal()) * options.noise_ut;
            noise = noise * rho + fresh * (1.0 - rho * rho).sqrt();
            let mut measured = self.sensor(t) + noise;
            if options.lsb_ut > 0.0 {
                measured = measured.map(|value| (value / options.lsb_ut).round() * options.lsb_ut);
            }
            let up = self.attitude.body_to_world(t).transpose() * Vector3::new(0.0, 0.0, -GRAVITY_MPS2);
            let acceleration = up + self.attitude.lever_acceleration(t);
            let acceleration = acceleration + Vector3::from_fn(|_, _| normal()) * options.accel_noise_mps2;
            let turn = self.attitude.rates(t) + Vector3::from_fn(|_, _| normal()) * options.gyro_noise_radps;
            let values = std::iter::once(t)
                .chain(measured.iter().copied())
                .chain(acceleration.iter().copied())
                .chain(turn.iter().copied())
                .chain(covariates.iter().map(|name| self.covariate(name, t)))
                .chain(std::iter::once(self.heading_deg(t)));
            for (column, value) in columns.iter_mut().zip(values) {
                column.push(value);
            }
            body_field_ut.push(self.body_field_ut(t));
        }
        let quantum = options.lsb_ut;
        let truth = Truth {
            hard_iron_ut: self.hard_iron_ut.into(),
            soft_iron: core::array::from_fn(|i| core::array::from_fn(|j| self.soft_iron[(i, j)])),
            field_ut: options.field_ut,
            noise_ut: (options.noise_ut * options.noise_ut + quantum * quantum / 12.0).sqrt(),
            effects: self.hidden.clone(),
            body_field_ut,
        };
        let mut log = Log { names, columns, truth };
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed ^ 0x6661_756c_7473);
        for fault in &options.faults {
            fault.inflict(&mut log, &mut rng);
        }
        for name in &options.drop_columns {
            if let Some(index) = log.position(name) {
                log.names.remove(index);
                log.columns.remove(index);
            }
        }
        log
    }
}
