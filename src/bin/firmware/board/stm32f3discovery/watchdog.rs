//! The watchdog: fed while both the loop turns and the sampler's interrupt comes.

use super::sampling::SEAT;
use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;

/// How long the firmware may stand still, µs: far beyond the longest solve and the slowest erase (0.04 s).
const LIMIT_US: u32 = 2_500_000;

/// Whether the watchdog has restarted the board because it was not fed.
pub fn was_hung() -> bool {
    let was_hung = pac::RCC.csr().read().iwdgrstf();
    // Or the next restart would look like this one.
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    was_hung
}

/// Restarts the board. Memory keeps what it holds.
pub fn restart() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}

/// Feeds it, for what comes after the end of everything else.
pub fn feed() {
    pac::IWDG.kr().write(|w| w.set_key(pac::iwdg::vals::Key::RESET));
}

/// The watchdog, running.
pub struct Watchdog {
    inner: IndependentWatchdog<'static, IWDG>,
    beats: u32,
}

impl Watchdog {
    pub(super) fn start(peripheral: Peri<'static, IWDG>) -> Self {
        // It stands still with the core, where a debugger holds that.
        pac::DBGMCU.apb1fzr().modify(|w| w.set_iwdg(true));
        let mut inner = IndependentWatchdog::new(peripheral, LIMIT_US);
        inner.unleash();
        Self { inner, beats: SEAT.beats() }
    }

    /// The loop has turned; it counts where the sampler has had its turn too.
    pub fn turned(&mut self) {
        let beats = SEAT.beats();
        if beats != self.beats {
            self.beats = beats;
            self.inner.pet();
        }
    }
}
