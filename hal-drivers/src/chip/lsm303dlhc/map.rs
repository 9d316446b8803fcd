//! The register map, for the driver.

use super::register as reg;
use super::types::Config;
use crate::chip::description::{Chip, Identity, Thermometer, Write};
use ironout_sensor::{AxisMap, Reading, Sensor};

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: reg::IRA, bytes: &reg::IDENTITY };
    const STATUS: (u8, u8) = (reg::SR, reg::SR_DRDY);
    const OUTPUT: u8 = reg::OUT_X_H;
    // The first one may be of the gain before.
    const DROPPED: u8 = 1;
    type Output = [u8; 6];
    type Writes = [Write; 3];

    fn address(&self) -> u8 {
        reg::ADDRESS
    }

    fn writes(&self) -> [Write; 3] {
        [
            Write::kept(reg::CRA, self.cra()),
            Write::kept(reg::CRB, self.range.crb()),
            Write::kept(reg::MR, reg::MR_CONTINUOUS),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "LSM303DLHC",
            ut_per_count: self.range.ut_per_count(),
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: reg::FULL_SCALE,
            bits: 12,
            shift: 0,
        }
    }

    fn decode(&self, &[xh, xl, zh, zl, yh, yl]: &[u8; 6]) -> Reading {
        let counts = [[xh, xl], [yh, yl], [zh, zl]].map(i16::from_be_bytes);
        // The chip says −4096; any other value beyond 12 bits was flipped on the bus and is no measurement either.
        Reading { counts, overflow: counts.map(|axis| !reg::VALID.contains(&axis)) }
    }

    fn thermometer(&self) -> Thermometer {
        // Behind the outputs the address pointer does not go on to the next register (it goes to 0).
        if self.temperature {
            Thermometer::Split { high: reg::TEMP_OUT_H, low: reg::TEMP_OUT_L }
        } else {
            Thermometer::None
        }
    }

    fn celsius(&self, bytes: [u8; 2]) -> f32 {
        self.temperature_format.celsius(bytes)
    }
}
