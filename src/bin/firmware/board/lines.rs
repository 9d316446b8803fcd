//! A two-wire bus that a chip holds down.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::i2c::ErrorKind;

/// Clocks a chip out of an unfinished byte and ends the transfer. Both lines are open-drain outputs that can be read, let go; `half`
/// waits for half a bit.
///
/// # Errors
/// [`ErrorKind::Bus`] where a line is held down all the same.
pub fn free(
    clock: &mut (impl InputPin + OutputPin),
    data: &mut (impl InputPin + OutputPin),
    half: impl Fn(),
) -> Result<(), ErrorKind> {
    half();
    for _ in 0..9 {
        if data.is_high().unwrap_or(false) {
            break;
        }
        let _ = clock.set_low();
        half();
        let _ = clock.set_high();
        half();
    }
    // The stop condition.
    let _ = data.set_low();
    half();
    let _ = data.set_high();
    half();
    let is_free = clock.is_high().unwrap_or(false) && data.is_high().unwrap_or(false);
    if is_free { Ok(()) } else { Err(ErrorKind::Bus) }
}
