//! The watchdog: fed while both the loop turns and the sampler's interrupt comes.

use super::sampling::SEAT;
use embassy_nrf::Peri;
use embassy_nrf::pac;
use embassy_nrf::peripherals::WDT;
use embassy_nrf::wdt::{self, HaltConfig, WatchdogHandle};

/// How long the firmware may stand still, in ticks of 32768 Hz: 2.5 s, far beyond the longest solve and the slowest erase (0.09 s).
const LIMIT_TICKS: u32 = 81_920;

/// Whether the watchdog has restarted the board because it was not fed.
pub fn was_hung() -> bool {
    let was_hung = pac::POWER.resetreas().read().dog();
    // Ones clear it: or the next restart would look like this one.
    pac::POWER.resetreas().write(|w| w.set_dog(true));
    was_hung
}

/// Restarts the board. Memory keeps what it holds.
pub fn restart() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}

/// Feeds it, for what comes after the end of everything else.
pub fn feed() {
    // SAFETY: nothing else runs any more.
    unsafe { WatchdogHandle::steal::<WDT>(0) }.pet();
}

/// The watchdog, running.
pub struct Watchdog {
    handle: WatchdogHandle,
    beats: u32,
}

impl Watchdog {
    /// `None` where it runs already, otherwise set up: it goes on over a restart.
    pub(super) fn start(peripheral: Peri<'static, WDT>) -> Option<Self> {
        let mut config = wdt::Config::default();
        config.timeout_ticks = LIMIT_TICKS;
        config.action_during_debug_halt = HaltConfig::Pause;
        let (_, [handle]) = wdt::Watchdog::try_new(peripheral, config).ok()?;
        Some(Self { handle, beats: SEAT.beats() })
    }

    /// The loop has turned; it counts where the sampler has had its turn too.
    pub fn turned(&mut self) {
        let beats = SEAT.beats();
        if beats != self.beats {
            self.beats = beats;
            self.handle.pet();
        }
    }
}
