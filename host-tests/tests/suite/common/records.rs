//! Records for the tests of records and of the store.

use ironout::calibration::Calibration;
use ironout::effect::{
    AmbientField, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Effect, Gain, Lag, Nonlinearity, Offset, Past,
    Periodic, Power, Product, SoftIron, Step,
};
use ironout::extended::{Effects, FittedEffect};
use ironout::fit::{Method, Order};
use ironout::record::Record;

pub fn record(offset_x_ut: f64) -> Record {
    Record {
        sequence: 0,
        calibration: Calibration {
            offset_ut: [offset_x_ut, -1.0 / 3.0, 1e-17],
            matrix: [[1.01, 0.02, -0.03], [0.0, 0.97, 0.1], [0.0, 0.0, 1.1]],
            field_ut: 48.123_456_789,
        },
        effects: Effects::none(),
        method: Method::Adjusted,
        model: Order::Ellipsoid,
        samples: 3000,
        noise_ut: 0.25,
        rms_ut: 0.26,
        axes: None,
        predicted_error: ironout::record::PredictedError::UNKNOWN,
        covariance: None,
        holds_for: None,
    }
}

pub fn bytes(record: &Record) -> Vec<u8> {
    record.encode().expect("it fits").as_bytes().to_vec()
}

pub fn fitted(effect: BuiltIn<f64>) -> FittedEffect<f64> {
    let k = Effect::<f64>::coefficients(&effect);
    let coefficients = std::array::from_fn(|i| if i < k { 0.1 / (i + 1) as f64 } else { 0.0 });
    // In single precision, as a record keeps them.
    let std_errors = std::array::from_fn(|i| if i < k { f64::from(0.01_f32 / (i + 1) as f32) } else { 0.0 });
    FittedEffect::new(effect, coefficients, std_errors)
}

pub fn all_effects() -> [BuiltIn<f64>; 16] {
    let column = ColumnName::new("battery_current_a").expect("a name");
    let offset = |power, past| BuiltIn::Offset(Offset { column, reference: 1.0 / 3.0, power, past });
    [
        offset(Power::Linear, Past::Now),
        offset(Power::Squared, Past::Now),
        offset(Power::Linear, Past::Delayed(0.1)),
        offset(Power::Squared, Past::Delayed(0.1)),
        offset(Power::Linear, Past::LowPass(3.5)),
        BuiltIn::SoftIron(SoftIron { column, reference: 0.5 }),
        BuiltIn::Product(Product {
            columns: ColumnName::new("servo*current_a").expect("a name"),
            reference: 0.25,
        }),
        BuiltIn::Gain(Gain { column, reference: -0.7 }),
        BuiltIn::Field(AmbientField { column, reference: 1e-7 }),
        BuiltIn::Drift(Drift { reference_s: 61.7 }),
        BuiltIn::Step(Step { at_s: 12.34 }),
        BuiltIn::Lag(Lag),
        BuiltIn::Eddy(Eddy),
        BuiltIn::Nonlinearity(Nonlinearity),
        BuiltIn::CrossAxis(CrossAxis),
        BuiltIn::Periodic(Periodic { frequency_hz: 16.67, reference_s: 0.1 }),
    ]
}

pub fn with(effects: &[BuiltIn<f64>]) -> Record {
    let mut record = record(93.25);
    for effect in effects {
        record.effects.push(fitted(*effect)).expect("four at most");
    }
    record
}

/// The same record, the range of every column known, in single precision, as a record keeps it.
pub fn with_ranges(record: &Record) -> Record {
    let mut effects = Effects::none();
    for (index, fitted) in record.effects.iter().enumerate() {
        let columns = Effect::<f64>::columns(&fitted.effect);
        let least = f64::from(-1.1_f32 - index as f32);
        let ranges = columns.map(|column| column.map(|_| [least, f64::from(48.7_f32)]));
        effects.push(fitted.over(ranges)).expect("four at most");
    }
    Record { effects, ..*record }
}

pub fn with_crc(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let crc = bytes[..body].iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1)))
    });
    bytes[body..].copy_from_slice(&(!crc).to_le_bytes());
    bytes
}
