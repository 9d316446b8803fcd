//! What stands in the slots, and what becomes of it.

use super::active::Active;
use super::machine::Device;
use crate::record::Record;
use crate::store::BothSlots;

impl Device {
    /// Takes note of what stands in the slots. The record found is put to work where none was found before, or not all could
    /// be read; one that is at work already goes on with the columns it was fed.
    #[inline(never)]
    pub(super) fn adopt(&mut self, slots: BothSlots, record: Option<&Record>) {
        self.slots = slots;
        let was_unread = self.store_watch.is_unread();
        if slots.unreadable().is_some() {
            self.store_watch.failed(self.now_ms);
        } else {
            self.store_watch.answered();
        }
        if let (true, Some((slot, _)), Some(record)) = (was_unread, slots.current(), record) {
            let at_work = self.active.as_ref().is_some_and(|active| active.record == *record);
            if !at_work {
                self.learner_inputs.learner.begin(&record.calibration);
                Active::install(&mut self.active, slot, record, self.config.sensor.axes);
            }
        }
    }

    /// What stood in the slots when they were looked at last.
    pub const fn slots(&self) -> BothSlots {
        self.slots
    }
}
