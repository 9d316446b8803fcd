//! What a log hides.

use crate::linalg::{Mat3, Quat, Vec3, sub, to_ned};
use std::fmt::Write;

/// One hidden effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Hidden {
    /// Effect id, or the nearest one for a cause outside of the catalogue.
    pub id: String,
    /// What it is, in words.
    pub words: String,
    /// True when the catalogue of effects has exactly this one.
    pub in_catalogue: bool,
    /// Its numbers: `at_s` of a step, `frequency_hz` of a tone, `delay_s` of a lag or of a column (negative where
    /// the column is late), `tau_s` of a low-pass.
    pub parameters: Vec<(&'static str, f64)>,
    /// Columns that drive it.
    pub columns: Vec<String>,
    /// False when a column that drives it is not in the log.
    pub logged: bool,
    /// `strength_ut` as a multiple of the noise.
    pub strength: f64,
    /// Part of the change of the magnitude that no offset and no matrix can imitate, µT rms. Of a lag: the change
    /// of the dip, times the field magnitude.
    pub strength_ut: f64,
    /// Whole change of the magnitude, µT rms.
    pub magnitude_rms_ut: f64,
    /// Disturbance of the measured vector, µT rms of the three axes together.
    pub vector_rms_ut: f64,
    /// Disturbance of the measured vector at every sample, µT.
    pub disturbance_ut: Vec<Vec3>,
}

/// Truth behind a log. Frames: body x forward, y right, z down; world NED.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Name of the kind.
    pub kind: String,
    /// Number of the log in its kind.
    pub number: u64,
    /// Hidden effects, none in logs that hide nothing.
    pub hidden: Vec<Hidden>,
    /// Columns that cause nothing.
    pub decoys: Vec<String>,
    /// How the body moved, in words.
    pub motion: String,
    /// Share of 96 equal areas of the sphere that the field's directions in the body frame visit.
    pub coverage: f64,
    /// Field magnitude, µT.
    pub field_ut: f64,
    /// Dip, positive downward, degrees.
    pub dip_deg: f64,
    /// Declination, positive eastward, degrees.
    pub declination_deg: f64,
    /// Measured field where the true one is zero and no effect acts, µT.
    pub offset_ut: Vec3,
    /// A in measured = A h + offset + disturbances + noise.
    pub matrix: Mat3,
    /// Standard deviation of the noise of each axis without quantisation, µT.
    pub sigma_ut: Vec3,
    /// Noise that strengths are multiples of: the rms over the axes, with the quantisation's LSB²/12, µT.
    pub noise_ut: f64,
    /// Colour of the noise, in words.
    pub noise: String,
    /// Step of the readings, µT; 0 when they are not quantised.
    pub lsb_ut: f64,
    /// Rate, Hz.
    pub rate_hz: f64,
    /// Zero rate of the gyro, rad/s.
    pub gyro_bias_radps: Vec3,
    /// Zero error of the accelerometer, m/s².
    pub accel_bias_mps2: Vec3,
    /// Angle between the measured specific force and the true vertical, degrees rms; NaN without accelerometer.
    pub accel_tilt_rms_deg: f64,
    /// True field in the body frame, of the constant magnitude `field_ut`, µT. A changing ambient field is an
    /// effect, not part of this.
    pub field_body_ut: Vec<Vec3>,
    /// True orientation at every sample, body to NED, w, x, y, z.
    pub attitude: Vec<Quat>,
}

impl Truth {
    /// Sum of all disturbances of the measured vector, µT.
    pub fn disturbance_ut(&self) -> Vec<Vec3> {
        let n = self.field_body_ut.len();
        let sum = |i: usize| {
            std::array::from_fn(|axis| self.hidden.iter().map(|h| h.disturbance_ut[i][axis]).sum())
        };
        (0..n).map(sum).collect()
    }

    /// Error of each corrected vector in the body frame, µT; `corrected` has to be scaled to `field_ut`.
    pub fn vector_errors_ut(&self, corrected: &[Vec3]) -> Vec<Vec3> {
        corrected.iter().zip(&self.field_body_ut).map(|(&c, &h)| sub(c, h)).collect()
    }

    /// Error of the heading that each corrected vector gives when the tilt is known exactly, degrees.
    pub fn heading_errors_deg(&self, corrected: &[Vec3]) -> Vec<f64> {
        let error = |(&c, &q): (&Vec3, &Quat)| {
            let ned = to_ned(q, c);
            let off = self.declination_deg - ned[1].atan2(ned[0]).to_degrees();
            (off + 180.0).rem_euclid(360.0) - 180.0
        };
        corrected.iter().zip(&self.attitude).map(error).collect()
    }

    /// JSON object with every number; what is unknown is null.
    pub fn json(&self) -> String {
        let mut hidden = Vec::new();
        for h in &self.hidden {
            let parameters: Vec<String> =
                h.parameters.iter().map(|(k, v)| format!("{}:{v}", text(k))).collect();
            let columns: Vec<String> = h.columns.iter().map(|c| text(c)).collect();
            hidden.push(format!(
                "{{\"id\":{},\"words\":{},\"in_catalogue\":{},\"parameters\":{{{}}},\"columns\":[{}],\"logged\":{},\"strength\":{},\
                 \"strength_ut\":{},\"magnitude_rms_ut\":{},\"vector_rms_ut\":{}}}",
                text(&h.id),
                text(&h.words),
                h.in_catalogue,
                parameters.join(","),
                columns.join(","),
                h.logged,
                h.strength,
                h.strength_ut,
                h.magnitude_rms_ut,
                h.vector_rms_ut
            ));
        }
        let decoys: Vec<String> = self.decoys.iter().map(|d| text(d)).collect();
        let tilt = if self.accel_tilt_rms_deg.is_finite() {
            self.accel_tilt_rms_deg.to_string()
        } else {
            "null".into()
        };
        let mut out = String::from("{");
        let mut field = |key: &str, value: &str| {
            let comma = if key == "kind" { "" } else { ",\n" };
            let _ = write!(out, "{comma}\"{key}\":{value}");
        };
        field("kind", &text(&self.kind));
        field("number", &self.number.to_string());
        field("hidden", &format!("[{}]", hidden.join(",")));
        field("decoys", &format!("[{}]", decoys.join(",")));
        field("motion", &text(&self.motion));
        field("coverage", &self.coverage.to_string());
        field("field_ut", &self.field_ut.to_string());
        field("dip_deg", &self.dip_deg.to_string());
        field("declination_deg", &self.declination_deg.to_string());
        field("offset_ut", &format!("{:?}", self.offset_ut));
        field("matrix", &format!("{:?}", self.matrix));
        field("sigma_ut", &format!("{:?}", self.sigma_ut));
        field("noise_ut", &self.noise_ut.to_string());
        field("noise", &text(&self.noise));
        field("lsb_ut", &self.lsb_ut.to_string());
        field("rate_hz", &self.rate_hz.to_string());
        field("gyro_bias_radps", &format!("{:?}", self.gyro_bias_radps));
        field("accel_bias_mps2", &format!("{:?}", self.accel_bias_mps2));
        field("accel_tilt_rms_deg", &tilt);
        field("field_body_ut", &format!("{:?}", self.field_body_ut));
        field("attitude", &format!("{:?}", self.attitude));
        out.push_str("}\n");
        out
    }
}

/// JSON string.
fn text(s: &str) -> String {
    format!("\"{}\"", s.replace('\\', "\\\\").replace('"', "\\\""))
}
