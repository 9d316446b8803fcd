//! Sampling a world into a log.

use crate::decoy::{self, Decoy};
use crate::log::{Log, Truth};
use crate::noise::Source;
use crate::world::World;
use nalgebra::Vector3;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

impl World {
    /// Names of the covariates in the log: the usual three, and those that a hidden effect follows.
    fn covariate_names(&self) -> Vec<String> {
        let mut names: Vec<String> = ["temp_c", "current_a", "height_m"].map(String::from).to_vec();
        for spec in &self.scenery.options.effects {
            for column in spec.columns() {
                if !names.iter().any(|name| name == column) {
                    names.push(column.to_string());
                }
            }
        }
        names
    }

    /// Samples the world into a log with every column, adds the sensors' noise and quantisation, then the faults.
    pub fn run(&self) -> Log {
        let options = &self.scenery.options;
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
        let mut noise = Source::new(options.noise, rho, options.noise_ut, rows, &mut normal);
        for row in 0..rows {
            let t = row as f64 / options.rate_hz;
            let mut measured = self.sensor(t) + noise.next(&mut normal);
            if options.lsb_ut > 0.0 {
                measured = measured.map(|value| (value / options.lsb_ut).round() * options.lsb_ut);
            }
            let acceleration = Vector3::from(self.accel_mps2(t));
            let acceleration = acceleration + Vector3::from_fn(|_, _| normal()) * options.accel_noise_mps2;
            let turn =
                self.scenery.attitude.rates(t) + Vector3::from_fn(|_, _| normal()) * options.gyro_noise_radps;
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
            hard_iron_ut: self.scenery.hard_iron_ut.into(),
            soft_iron: core::array::from_fn(|i| core::array::from_fn(|j| self.scenery.soft_iron[(i, j)])),
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
        self.spoil(&mut log);
        for name in &options.drop_columns {
            if let Some(index) = log.position(name) {
                log.names.remove(index);
                log.columns.remove(index);
            }
        }
        log
    }
    /// Adds the columns that cause nothing, empties cells, and stamps rows when they arrive.
    fn spoil(&self, log: &mut Log) {
        let options = &self.scenery.options;
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed ^ 0x6465_636f_7973);
        let (rows, row_s) = (log.rows(), 1.0 / options.rate_hz);
        for (name, decoy) in &options.decoys {
            let other = match decoy {
                Decoy::Alike { column, .. } => log.column(column),
                _ => None,
            };
            let values = decoy.values(rows, row_s, other, &mut rng);
            log.names.push(name.clone());
            log.columns.push(values);
        }
        for (name, share) in &options.empty_cells {
            if let Some(index) = log.position(name) {
                decoy::empty(&mut log.columns[index], *share, row_s, &mut rng);
            }
        }
        if let (true, Some(time)) = (options.arrival_jitter_rows > 0.0, log.position("t_s")) {
            let mut last = f64::NEG_INFINITY;
            for value in &mut log.columns[time] {
                let late = rng.random_range(0.0..options.arrival_jitter_rows) * row_s;
                last = (*value + late).max(last);
                *value = last;
            }
        }
    }
}
