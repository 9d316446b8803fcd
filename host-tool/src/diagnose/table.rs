//! The log as the diagnosis sees it: borrowed columns.

/// Borrowed columns of equal length. A missing cell is NaN.
#[derive(Debug, Clone, Default)]
pub struct Table<'a> {
    /// Time, s, not decreasing.
    pub time_s: Option<&'a [f64]>,
    /// The magnetometer, µT.
    pub field_ut: [&'a [f64]; 3],
    /// The same as the sensor's 16-bit counts, and their scale, µT a count: from these a fit gives the board's bits.
    pub counts: Option<(&'a [[i16; 3]], [f64; 3])>,
    /// Specific force, m/s².
    pub accel_mps2: Option<[&'a [f64]; 3]>,
    /// Rate of turn, rad/s.
    pub gyro_radps: Option<[&'a [f64]; 3]>,
    /// Reference heading, degrees.
    pub heading_deg: Option<&'a [f64]>,
    /// Every other numeric column.
    pub covariates: Vec<Named<'a>>,
}

/// A covariate.
#[derive(Debug, Clone)]
pub struct Named<'a> {
    /// Its header.
    pub name: &'a str,
    /// Its values.
    pub values: &'a [f64],
    /// Cells that hold NaN or an infinity written out.
    pub not_finite: usize,
}

impl Table<'_> {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.field_ut[0].len()
    }

    /// The measured vector of a row.
    pub fn field(&self, row: usize) -> [f64; 3] {
        self.field_ut.map(|axis| axis[row])
    }
}

impl<'a> From<&'a ironout_host_tests::world::Log> for Table<'a> {
    fn from(log: &'a ironout_host_tests::world::Log) -> Self {
        let triple = |names: [&str; 3]| -> Option<[&'a [f64]; 3]> {
            let [x, y, z] = names.map(|name| log.column(name));
            Some([x?, y?, z?])
        };
        let accel = ["ax_mps2", "ay_mps2", "az_mps2"];
        let gyro = ["gx_radps", "gy_radps", "gz_radps"];
        let field = ["mx_ut", "my_ut", "mz_ut"];
        let known = |name: &str| {
            accel.contains(&name)
                || gyro.contains(&name)
                || field.contains(&name)
                || ["t_s", "heading_deg"].contains(&name)
        };
        Table {
            time_s: log.column("t_s"),
            field_ut: triple(field).unwrap_or_default(),
            counts: None,
            accel_mps2: triple(accel),
            gyro_radps: triple(gyro),
            heading_deg: log.column("heading_deg"),
            covariates: log
                .names
                .iter()
                .zip(&log.columns)
                .filter(|(name, _)| !known(name))
                .map(|(name, values)| Named { name, values, not_finite: 0 })
                .collect(),
        }
    }
}

impl<'a> From<&'a crate::input::Log> for Table<'a> {
    fn from(log: &'a crate::input::Log) -> Self {
        let triple = |axes: &'a [Vec<f64>; 3]| axes.each_ref().map(Vec::as_slice);
        Table {
            time_s: log.time_s.as_deref(),
            field_ut: triple(&log.field_ut),
            counts: log.counts.as_deref().zip(log.ut_per_count),
            accel_mps2: log.accel_mps2.as_ref().map(triple),
            gyro_radps: log.gyro_radps.as_ref().map(triple),
            heading_deg: log.heading_deg.as_deref(),
            covariates: log
                .covariates
                .iter()
                .map(|column| Named {
                    name: &column.name,
                    values: &column.values,
                    not_finite: column.not_finite,
                })
                .collect(),
        }
    }
}
