//! The sizes of the plain structs, which the header checks too.

use crate::calibration::IronoutCalibration;
use crate::live::IronoutOutside;
use crate::sensor::IronoutSensor;
use crate::status::{IronoutOutcome, IronoutStatus};

const _: () = {
    assert!(size_of::<IronoutSensor>() == 20);
    assert!(size_of::<IronoutCalibration>() == 80);
    assert!(size_of::<IronoutStatus>() == 48);
    assert!(size_of::<IronoutOutcome>() == 60);
    assert!(size_of::<IronoutOutside>() == 64);
};
