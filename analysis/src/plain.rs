//! The core's types as plain data, for serde: the core itself knows of no format.

use ironout::calibration::Calibration;
use ironout::effect::Bends;
use ironout::fit::{Method, Order};
use serde::de::Error;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// `{offset_ut, matrix, field_ut}`.
pub fn calibration<S: Serializer>(calibration: &Calibration<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    let mut object = serializer.serialize_struct("Calibration", 3)?;
    object.serialize_field("offset_ut", &calibration.offset_ut)?;
    object.serialize_field("matrix", &calibration.matrix)?;
    object.serialize_field("field_ut", &calibration.field_ut)?;
    object.end()
}

/// The same, or nothing.
pub fn calibration_if_any<S: Serializer>(
    value: &Option<Calibration<f64>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    struct Plain<'a>(&'a Calibration<f64>);
    impl Serialize for Plain<'_> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            calibration(self.0, serializer)
        }
    }
    value.as_ref().map(Plain).serialize(serializer)
}

/// `ellipsoid`, or the lower order that the data carried.
pub fn model<S: Serializer>(model: &Order, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(model.name())
}

/// The word of the contract.
pub fn method<S: Serializer>(method: &Method, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(method.name())
}

/// A method of that word.
pub fn method_of<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Method, D::Error> {
    let word = String::deserialize(deserializer)?;
    Method::parse(&word).ok_or_else(|| D::Error::custom(format!("there is no method {word:?}")))
}

/// Whether it is what most effects bend.
pub fn is_reading(bends: &Bends) -> bool {
    *bends == Bends::Reading
}

/// `field` or `reading`.
pub mod bends {
    use super::*;

    /// The word.
    pub fn serialize<S: Serializer>(bends: &Bends, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(if is_reading(bends) { "reading" } else { "field" })
    }

    /// What a word says.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Bends, D::Error> {
        match String::deserialize(deserializer)?.as_str() {
            "reading" => Ok(Bends::Reading),
            "field" => Ok(Bends::Field),
            other => {
                Err(D::Error::custom(format!("an effect bends \"reading\" or \"field\", not {other:?}")))
            }
        }
    }
}
