//! The watchdog: fed while both the loop turns and the sampler's interrupt comes.

use super::sampling::SEAT;
use embassy_rp::pac;
use embassy_rp::peripherals::WATCHDOG;
use embassy_rp::{Peri, watchdog};
use embassy_time::Duration;

/// How long the firmware may stand still: far beyond the longest solve (0.05 s) and the slowest erase (0.4 s).
const LIMIT: Duration = Duration::from_millis(2_500);

/// Whether the watchdog has restarted the board because it was not fed.
pub fn was_hung() -> bool {
    let reason = pac::WATCHDOG.reason().read();
    reason.timer() && !reason.force()
}

/// Restarts the board by the watchdog: unlike the core's own request it resets the peripherals too. Memory keeps what it holds.
pub fn restart() -> ! {
    // SAFETY: nothing else runs any more.
    let mut watchdog = watchdog::Watchdog::new(unsafe { WATCHDOG::steal() });
    watchdog.trigger_reset();
    loop {
        cortex_m::asm::nop();
    }
}

/// Feeds it, for what comes after the end of everything else.
pub fn feed() {
    // SAFETY: it only writes one register, whole.
    watchdog::Watchdog::new(unsafe { WATCHDOG::steal() }).feed(LIMIT);
}

/// The watchdog, running.
pub struct Watchdog {
    inner: watchdog::Watchdog,
    beats: u32,
}

impl Watchdog {
    pub(super) fn start(peripheral: Peri<'static, WATCHDOG>) -> Self {
        let mut inner = watchdog::Watchdog::new(peripheral);
        inner.pause_on_debug(true);
        inner.start(LIMIT);
        Self { inner, beats: SEAT.beats() }
    }

    /// The loop has turned; it counts where the sampler has had its turn too.
    pub fn turned(&mut self) {
        let beats = SEAT.beats();
        if beats != self.beats {
            self.beats = beats;
            self.inner.feed(LIMIT);
        }
    }
}
