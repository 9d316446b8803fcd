//! The header lines of a blackbox log.

use crate::input::formats::blackbox::firmware::Firmware;
use std::collections::HashMap;

/// The line that every session begins with.
pub const MARK: &[u8] = b"H Product:Blackbox flight data recorder by Nicholas Sherlock\n";

/// The header lines of the session that begins `data`, by name.
pub fn lines(data: &[u8]) -> HashMap<&str, &str> {
    rows(data)
        .filter_map(|(_, line)| std::str::from_utf8(line.strip_prefix(b"H ")?).ok()?.split_once(':'))
        .map(|(name, value)| (name.trim(), value.trim_end()))
        .collect()
}

/// The header lines with the byte at which each begins.
fn rows(data: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = data.get(at..)?;
        if !rest.starts_with(b"H ") {
            return None;
        }
        let length = memchr::memchr(b'\n', rest)?;
        let row = (at, rest.get(..length)?);
        at += length + 1;
        Some(row)
    })
}

/// Makes the decoder read firmware that is newer, older, or another than it knows: how frames are written stands in the header
/// itself, and what depends on the firmware (names of modes, features, protocols) is not read here. Lines that the decoder asks for
/// and the firmware does not write under that name (Betaflight 3.0 and 3.1: `motor_pwm_protocol`) are added. Gives the firmware as
/// it was named, where that is not known.
pub fn generalise(data: &mut Vec<u8>) -> Option<String> {
    let firmware = Firmware::of(lines(data).get("Firmware revision").copied().unwrap_or_default());
    let named = lines(data).get("Firmware revision").map(|name| name.to_string()).unwrap_or_default();
    let known = firmware.is_decoded();
    let mut header: Vec<u8> = Vec::new();
    let mut end = 0;
    let (mut revision, mut protocol) = (false, false);
    for (at, line) in rows(data) {
        end = at + line.len() + 1;
        let name = line.get(2..memchr::memchr(b':', line).unwrap_or(2)).unwrap_or_default();
        revision |= name == b"Firmware revision";
        protocol |= name == b"motor_pwm_protocol";
        let instead: Option<&[u8]> = match name {
            _ if known => None,
            b"Firmware revision" if firmware.inav => Some(b"H Firmware revision:INAV 8.0.0"),
            b"Firmware revision" => Some(b"H Firmware revision:Betaflight 4.5.0"),
            b"debug_mode" => Some(b"H debug_mode:0"),
            b"features" => Some(b"H features:0"),
            b"motor_pwm_protocol" => Some(b"H motor_pwm_protocol:0"),
            b"fields_disabled_mask" => Some(b"H fields_disabled_mask:0"),
            _ => None,
        };
        header.extend(instead.unwrap_or(line));
        header.push(b'\n');
    }
    if !revision {
        header.extend(b"H Firmware revision:Betaflight 4.5.0\n");
    }
    if !protocol {
        header.extend(b"H motor_pwm_protocol:0\n");
    }
    if !known || !protocol {
        data.splice(..end.min(data.len()), header);
    }
    (!known).then_some(if named.is_empty() { "unnamed firmware".into() } else { named })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newer_firmware_is_named_as_one_that_is_known() {
        let mut data = MARK.to_vec();
        data.extend(b"H Data version:2\nH Firmware revision:Betaflight 2025.12.1 (abc) STM32F405\nH debug_mode:97\nI\x01");
        assert_eq!(generalise(&mut data).as_deref(), Some("Betaflight 2025.12.1 (abc) STM32F405"));
        let after = lines(&data);
        assert_eq!(after["Firmware revision"], "Betaflight 4.5.0");
        assert_eq!((after["debug_mode"], after["motor_pwm_protocol"]), ("0", "0"));
        assert!(data.ends_with(b"\nI\x01"));
        assert_eq!(generalise(&mut data), None);
        // Betaflight 3.0 names its revision alone, and its protocol otherwise.
        let mut data = MARK.to_vec();
        data.extend(b"H Firmware revision:c8a3ae8\nH fast_pwm_protocol:7\nI\x01");
        assert_eq!(generalise(&mut data).as_deref(), Some("c8a3ae8"));
        assert_eq!(lines(&data)["Firmware revision"], "Betaflight 4.5.0");
        assert!(lines(&data).contains_key("motor_pwm_protocol") && data.ends_with(b"\nI\x01"));
    }
}
