//! Arrow's arrays as columns of numbers, dates and texts.

use crate::input::text::{GridColumn, number_of};
use crate::input::unit::{Quantity, Unit};
use arrow_array::cast::AsArray;
use arrow_array::types::{self as t, ArrowPrimitiveType};
use arrow_array::{Array, ArrayRef};
use arrow_schema::{DataType, TimeUnit};

const DAY_S: f64 = 86_400.0;

/// Why a column of that type is not read: what its cells are. `None` if it is.
pub(super) fn unreadable(kind: &DataType) -> Option<&'static str> {
    match kind {
        DataType::List(_)
        | DataType::LargeList(_)
        | DataType::FixedSizeList(..)
        | DataType::ListView(_)
        | DataType::LargeListView(_) => Some("a list"),
        DataType::Struct(_) => Some("a struct"),
        DataType::Map(..) => Some("a map"),
        DataType::Dictionary(_, values) => unreadable(values),
        DataType::Binary | DataType::LargeBinary | DataType::FixedSizeBinary(_) | DataType::BinaryView => {
            Some("bytes")
        }
        DataType::Interval(_) => Some("an interval of months and days"),
        DataType::Union(..) | DataType::RunEndEncoded(..) | DataType::Decimal256(..) => Some("of a type"),
        _ => None,
    }
}

/// Appends the cells of an array. A null is an empty cell.
pub(super) fn append(column: &mut GridColumn, array: &ArrayRef) {
    let kind = array.data_type();
    if let DataType::Dictionary(..) = kind {
        dictionary(column, array);
    } else if let Some(texts) = texts(array) {
        texts.into_iter().for_each(|text| push(column, text));
    } else if let Some(values) = numbers(array) {
        match kind {
            DataType::Timestamp(..)
            | DataType::Date32
            | DataType::Date64
            | DataType::Time32(_)
            | DataType::Time64(_) => {
                column.dates += values.iter().filter(|value| value.is_finite()).count();
            }
            DataType::Duration(_) => column.unit = Unit::of("s", Quantity::Time),
            _ => column.not_finite += values.iter().filter(|value| value.is_infinite()).count(),
        }
        column.values.extend(values);
    } else {
        column.values.resize(column.values.len() + array.len(), f64::NAN);
    }
    if !column.codes.is_empty() {
        column.codes.resize(column.values.len(), 0);
    }
}

fn push(column: &mut GridColumn, cell: Option<&str>) {
    let cell = cell.unwrap_or_default();
    column.push(cell, number_of(cell, false));
}

fn dictionary(column: &mut GridColumn, array: &ArrayRef) {
    let Some(all) = array.as_any_dictionary_opt() else { return };
    let keys = numbers_of(all.keys());
    let key = |row: usize| keys.as_ref()?.get(row).filter(|key| key.is_finite()).map(|key| *key as usize);
    let (texts, values) = (texts(all.values()), numbers(all.values()));
    for row in 0..array.len() {
        match (&texts, &values) {
            (Some(texts), _) => push(column, key(row).and_then(|key| texts.get(key).copied().flatten())),
            (None, values) => {
                let value = key(row).and_then(|key| values.as_ref()?.get(key).copied());
                column.values.push(value.unwrap_or(f64::NAN));
            }
        }
    }
}

fn texts(array: &ArrayRef) -> Option<Vec<Option<&str>>> {
    Some(match array.data_type() {
        DataType::Utf8 => array.as_string::<i32>().iter().collect(),
        DataType::LargeUtf8 => array.as_string::<i64>().iter().collect(),
        DataType::Utf8View => array.as_string_view().iter().collect(),
        _ => return None,
    })
}

fn numbers(array: &ArrayRef) -> Option<Vec<f64>> {
    numbers_of(array.as_ref())
}

/// Numbers, times in seconds; NaN for null.
fn numbers_of(array: &dyn Array) -> Option<Vec<f64>> {
    fn each<T: ArrowPrimitiveType>(array: &dyn Array, number: impl Fn(T::Native) -> f64) -> Vec<f64> {
        array.as_primitive::<T>().iter().map(|value| value.map_or(f64::NAN, &number)).collect()
    }
    // By way of nanoseconds, so that the digits are those of numpy's dates.
    let seconds = |per_s: i128| move |value: i64| (i128::from(value) * (1_000_000_000 / per_s)) as f64 / 1e9;
    let ten = |scale: i8| 10_f64.powi(i32::from(scale));
    Some(match array.data_type() {
        DataType::Int8 => each::<t::Int8Type>(array, f64::from),
        DataType::Int16 => each::<t::Int16Type>(array, f64::from),
        DataType::Int32 => each::<t::Int32Type>(array, f64::from),
        DataType::Int64 => each::<t::Int64Type>(array, |value| value as f64),
        DataType::UInt8 => each::<t::UInt8Type>(array, f64::from),
        DataType::UInt16 => each::<t::UInt16Type>(array, f64::from),
        DataType::UInt32 => each::<t::UInt32Type>(array, f64::from),
        DataType::UInt64 => each::<t::UInt64Type>(array, |value| value as f64),
        DataType::Float16 => each::<t::Float16Type>(array, f64::from),
        DataType::Float32 => each::<t::Float32Type>(array, f64::from),
        DataType::Float64 => each::<t::Float64Type>(array, |value| value),
        DataType::Boolean => array
            .as_boolean()
            .iter()
            .map(|value| value.map_or(f64::NAN, |is| f64::from(u8::from(is))))
            .collect(),
        DataType::Decimal32(_, scale) => {
            each::<t::Decimal32Type>(array, |value| f64::from(value) / ten(*scale))
        }
        DataType::Decimal64(_, scale) => each::<t::Decimal64Type>(array, |value| value as f64 / ten(*scale)),
        DataType::Decimal128(_, scale) => {
            each::<t::Decimal128Type>(array, |value| value as f64 / ten(*scale))
        }
        DataType::Timestamp(TimeUnit::Second, _) => each::<t::TimestampSecondType>(array, seconds(1)),
        DataType::Timestamp(TimeUnit::Millisecond, _) => {
            each::<t::TimestampMillisecondType>(array, seconds(1_000))
        }
        DataType::Timestamp(TimeUnit::Microsecond, _) => {
            each::<t::TimestampMicrosecondType>(array, seconds(1_000_000))
        }
        DataType::Timestamp(TimeUnit::Nanosecond, _) => {
            each::<t::TimestampNanosecondType>(array, seconds(1_000_000_000))
        }
        DataType::Duration(TimeUnit::Second) => each::<t::DurationSecondType>(array, seconds(1)),
        DataType::Duration(TimeUnit::Millisecond) => {
            each::<t::DurationMillisecondType>(array, seconds(1_000))
        }
        DataType::Duration(TimeUnit::Microsecond) => {
            each::<t::DurationMicrosecondType>(array, seconds(1_000_000))
        }
        DataType::Duration(TimeUnit::Nanosecond) => {
            each::<t::DurationNanosecondType>(array, seconds(1_000_000_000))
        }
        DataType::Date32 => each::<t::Date32Type>(array, |days| f64::from(days) * DAY_S),
        DataType::Date64 => each::<t::Date64Type>(array, seconds(1_000)),
        DataType::Time32(TimeUnit::Second) => each::<t::Time32SecondType>(array, f64::from),
        DataType::Time32(_) => each::<t::Time32MillisecondType>(array, |value| f64::from(value) / 1e3),
        DataType::Time64(TimeUnit::Microsecond) => {
            each::<t::Time64MicrosecondType>(array, seconds(1_000_000))
        }
        DataType::Time64(_) => each::<t::Time64NanosecondType>(array, seconds(1_000_000_000)),
        _ => return None,
    })
}
