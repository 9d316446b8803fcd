//! The header lines of a blackbox log.

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

/// Makes the decoder read firmware that is newer, or another, than it knows: how frames are written stands in the header itself,
/// and what depends on the firmware (names of modes, features, protocols) is not read here. Lengths do not change. Gives the
/// firmware as it was named, where something was changed.
pub fn generalise(data: &mut [u8]) -> Option<String> {
    let firmware = lines(data).get("Firmware revision")?.to_string();
    let mut words = firmware.split_whitespace();
    let (name, version) = (words.next()?.to_ascii_lowercase(), words.next()?);
    let mut numbers = version.split('.').map(|part| part.parse::<u32>().ok());
    let (major, minor) = (numbers.next().flatten()?, numbers.next().flatten()?);
    let inav = name == "inav";
    let known = match name.as_str() {
        "betaflight" => major == 4 && (2..6).contains(&minor),
        "inav" => (5..9).contains(&major),
        _ => false,
    };
    let neutral: &[u8] = if inav { b"INAV 8.0.0" } else { b"Betaflight 4.5.0" };
    if known || firmware.len() < neutral.len() {
        return None;
    }
    let places: Vec<(usize, usize, &[u8])> = rows(data)
        .filter_map(|(at, line)| {
            let colon = memchr::memchr(b':', line)?;
            let (value, end) = (at + colon + 1, at + line.len());
            match line.get(2..colon)? {
                b"Firmware revision" => Some((value, end, neutral)),
                b"debug_mode" | b"features" | b"motor_pwm_protocol" | b"fields_disabled_mask" => {
                    Some((value, end, &b"0"[..]))
                }
                _ => None,
            }
        })
        .collect();
    for (from, to, content) in places {
        let fill = if content == b"0" { b'0' } else { b' ' };
        if let Some(value) = data.get_mut(from..to) {
            for (index, byte) in value.iter_mut().enumerate() {
                *byte = content.get(index).copied().unwrap_or(fill);
            }
        }
    }
    Some(firmware)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newer_firmware_is_named_as_one_that_is_known() {
        let mut data = MARK.to_vec();
        data.extend(b"H Data version:2\nH Firmware revision:Betaflight 2025.12.1 (abc) STM32F405\nH debug_mode:97\nI\x01");
        let length = data.len();
        assert_eq!(generalise(&mut data).as_deref(), Some("Betaflight 2025.12.1 (abc) STM32F405"));
        let after = lines(&data);
        assert_eq!(after["Firmware revision"], "Betaflight 4.5.0");
        assert_eq!(after["debug_mode"], "00");
        assert_eq!(data.len(), length);
        assert_eq!(generalise(&mut data), None);
    }
}
