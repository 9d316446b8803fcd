//! Which firmware wrote a blackbox log, and the units that changed with its versions.

use std::collections::HashMap;

/// Volts of the reference of the analog-to-digital converter, and its greatest number.
const ADC: (f64, f64) = (3.3, 4095.0);

/// Name and version.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Firmware {
    /// Whether it is INAV.
    pub inav: bool,
    /// Whether it is Betaflight.
    betaflight: bool,
    /// Major and minor version and patch; `None` where the header names none, as before Betaflight 3.1.
    version: Option<[u32; 3]>,
}

impl Firmware {
    /// Of `Firmware revision` in the header: `Betaflight 4.5.0 (77d01ba3b) STM32F405`.
    pub fn of(revision: &str) -> Self {
        let mut words = revision.split_whitespace();
        let name = words.next().unwrap_or_default().to_ascii_lowercase();
        let version = words.next().and_then(|word| {
            let mut parts = word.split('.').map(|part| {
                let digits = part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len());
                part.get(..digits)?.parse().ok()
            });
            Some([parts.next()??, parts.next()??, parts.next().flatten().unwrap_or(0)])
        });
        Firmware { inav: name == "inav", betaflight: name == "betaflight", version }
    }

    /// Whether the decoder knows this version.
    pub fn is_decoded(&self) -> bool {
        match self.version {
            Some([major, minor, _]) if self.betaflight => major == 4 && (2..6).contains(&minor),
            Some([major, ..]) if self.inav => (5..9).contains(&major),
            _ => false,
        }
    }

    /// Whether it is a Betaflight before this version: those before 3.1 do not name theirs.
    fn is_before(&self, version: [u32; 3]) -> bool {
        match self.version {
            Some(own) => self.betaflight && own < version,
            None => !self.inav,
        }
    }

    /// Unit and scale of the battery's voltage; `None` where the header does not tell.
    pub fn voltage(&self, headers: &HashMap<&str, &str>) -> Option<(&'static str, f64)> {
        if self.is_before([3, 1, 0]) {
            let scale = numbers(headers, &["vbatscale", "vbat_scale"]).first().copied()?;
            return Some(("ADC", ADC.0 / ADC.1 * 0.1 * scale)).filter(|(_, scale)| *scale > 0.0);
        }
        Some(if self.is_before([4, 0, 0]) { ("0.1 V", 0.1) } else { ("0.01 V", 0.01) })
    }

    /// Unit and scale of the battery's current; `None` where the header does not tell, or the sensor has a zero of its own.
    pub fn current(&self, headers: &HashMap<&str, &str>) -> Option<(&'static str, f64)> {
        if self.is_before([3, 1, 0]) {
            // Offset in millivolts, scale in tenths of a millivolt per ampere.
            let [offset, scale] = numbers(headers, &["currentMeter", "currentSensor"]).try_into().ok()?;
            let amperes = ADC.0 * 1000.0 / ADC.1 * 10.0 / scale;
            return Some(("ADC", amperes))
                .filter(|(_, scale)| offset == 0.0 && scale.is_finite() && *scale > 0.0);
        }
        Some(("0.01 A", 0.01))
    }
}

fn numbers(headers: &HashMap<&str, &str>, names: &[&str]) -> Vec<f64> {
    let line = names.iter().find_map(|name| headers.get(name)).copied().unwrap_or_default();
    line.split(',').map_while(|word| word.trim().parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_follow_the_version() {
        let headers = HashMap::from([("vbatscale", "110"), ("currentMeter", "0,400")]);
        let volts = |revision: &str| Firmware::of(revision).voltage(&headers).map(|(unit, _)| unit);
        assert_eq!(volts("c8a3ae8"), Some("ADC"));
        assert_eq!(volts("Betaflight 3.1.7 (e1c4b5d) NAZE"), Some("0.1 V"));
        assert_eq!(volts("Betaflight 4.5.0 (0000000) STM32F7X2"), Some("0.01 V"));
        assert_eq!(volts("INAV 7.1.0 (a) MATEK"), Some("0.01 V"));
        let (_, scale) = Firmware::of("c8a3ae8").voltage(&headers).expect("a scale");
        assert!((scale * 1400.0 - 12.41).abs() < 0.01, "{scale}");
        let (_, scale) = Firmware::of("c8a3ae8").current(&headers).expect("a scale");
        assert!((scale * 1000.0 - 20.15).abs() < 0.01, "{scale}");
        assert_eq!(Firmware::of("c8a3ae8").voltage(&HashMap::new()), None);
        assert!(Firmware::of("Betaflight 4.4.2 (x) y").is_decoded());
        assert!(!Firmware::of("Betaflight 2025.12.1 (x) y").is_decoded());
    }
}
