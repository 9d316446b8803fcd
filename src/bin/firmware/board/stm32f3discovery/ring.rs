//! The ring of eight lights and the blue button.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AnyPin, Input, Level, Output, Speed};
use ironout::device::Shown;

/// The ring and the button.
pub struct Panel {
    /// From the front clockwise.
    lights: [Output<'static>; 8],
    button: Input<'static>,
}

impl Panel {
    pub(super) fn new(lights: [Peri<'static, AnyPin>; 8], button: Input<'static>) -> Self {
        Self { lights: lights.map(|pin| Output::new(pin, Level::Low, Speed::Low)), button }
    }

    /// Shows the state on all lights.
    pub fn show(&mut self, shown: &Shown) {
        let lit = shown.ring();
        for (index, light) in self.lights.iter_mut().enumerate() {
            light.set_level(if lit >> index & 1 != 0 { Level::High } else { Level::Low });
        }
    }

    /// Whether the button is down, bounces and all.
    pub fn button_down(&self) -> bool {
        self.button.is_high()
    }
}
