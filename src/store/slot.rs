//! The two places for a record, and what stands in them.

use core::fmt;

use crate::record::{DoesNotFit, RecordError, is_newer};

/// One of the two places for a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Slot {
    /// The first one.
    A,
    /// The second one.
    B,
}

impl Slot {
    /// Both, in order.
    pub const BOTH: [Slot; 2] = [Slot::A, Slot::B];

    /// 0 or 1.
    pub const fn index(self) -> usize {
        match self {
            Slot::A => 0,
            Slot::B => 1,
        }
    }

    /// The one that is not this one.
    pub const fn other(self) -> Self {
        match self {
            Slot::A => Slot::B,
            Slot::B => Slot::A,
        }
    }
}

impl fmt::Display for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.index())
    }
}

/// Why the store did not do its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreError {
    /// A slot could not be read.
    Read(Slot),
    /// A slot could not be written.
    Write(Slot),
    /// Writing failed half-way in cells that have to be erased before they are written again: the slot is to be written from its
    /// first byte again.
    HalfWritten(Slot),
    /// A slot was written, and reads back as something else.
    NotConfirmed(Slot),
    /// The record's effects take more room than a slot has.
    DoesNotFit,
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StoreError::Read(slot) => write!(f, "slot {slot} cannot be read"),
            StoreError::Write(slot) | StoreError::HalfWritten(slot) => {
                write!(f, "slot {slot} cannot be written")
            }
            StoreError::NotConfirmed(slot) => write!(f, "slot {slot} does not read back as written"),
            StoreError::DoesNotFit => DoesNotFit.fmt(f),
        }
    }
}

impl core::error::Error for StoreError {}

/// What stands in a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlotState {
    /// The record that counts, by its sequence number.
    Current(u32),
    /// A sound record, older than the current one.
    Stale(u32),
    /// No usable record, and why.
    Unusable(RecordError),
    /// Its bytes cannot be read, though the memory answers elsewhere: power was lost while a flash with error correction was
    /// written. It holds nothing, and is erased and written as an empty one.
    Damaged,
    /// The memory did not answer.
    Unreadable,
}

impl fmt::Display for SlotState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SlotState::Current(sequence) => write!(f, "current-{sequence}"),
            SlotState::Stale(sequence) => write!(f, "stale-{sequence}"),
            SlotState::Unusable(why) => write!(f, "{why}"),
            SlotState::Damaged => f.write_str("damaged"),
            SlotState::Unreadable => f.write_str("unreadable"),
        }
    }
}

impl SlotState {
    /// The sequence number of a sound record, of unusable ones too.
    const fn sequence(&self) -> Option<u32> {
        match self {
            SlotState::Current(sequence)
            | SlotState::Stale(sequence)
            | SlotState::Unusable(
                RecordError::Unsupported { sequence, .. } | RecordError::Unsound { sequence },
            ) => Some(*sequence),
            SlotState::Unusable(RecordError::Empty | RecordError::Torn)
            | SlotState::Damaged
            | SlotState::Unreadable => None,
        }
    }

    /// How much is lost where this is overwritten: nothing, a broken record, one that other firmware may still read. A damaged slot
    /// comes before an empty one, so that a second cut in a row spoils no second slot.
    const fn worth(&self) -> u8 {
        match self {
            SlotState::Damaged => 0,
            SlotState::Unusable(RecordError::Empty) => 1,
            SlotState::Unusable(RecordError::Torn) => 2,
            SlotState::Unusable(RecordError::Unsound { .. }) => 3,
            SlotState::Unusable(RecordError::Unsupported { .. }) => 4,
            SlotState::Stale(_) => 5,
            SlotState::Unreadable | SlotState::Current(_) => 6,
        }
    }

    /// Whether no record is lost where this is overwritten.
    const fn is_free(&self) -> bool {
        self.worth() <= SlotState::Unusable(RecordError::Torn).worth()
    }
}

/// Both slots, as found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BothSlots {
    /// Slot A and slot B.
    pub states: [SlotState; 2],
}

impl BothSlots {
    /// The slot of the record in use, and its sequence number.
    pub fn current(&self) -> Option<(Slot, u32)> {
        Slot::BOTH.into_iter().zip(&self.states).find_map(|(slot, state)| match state {
            SlotState::Current(sequence) => Some((slot, *sequence)),
            _ => None,
        })
    }

    /// The first slot that did not answer, if any.
    pub fn unreadable(&self) -> Option<Slot> {
        let found = Slot::BOTH.into_iter().zip(&self.states);
        found.filter(|(_, state)| **state == SlotState::Unreadable).map(|(slot, _)| slot).next()
    }

    /// Where to write: never over the record in use, and rather over nothing or a torn record than over one that newer
    /// firmware still reads; of two of those, over the older one.
    pub(super) fn target(&self, in_use: Option<Slot>) -> Slot {
        if let Some(slot) = in_use.or(self.current().map(|(slot, _)| slot)) {
            return slot.other();
        }
        let [a, b] = &self.states;
        let b_is_older = match (a.sequence(), b.sequence()) {
            (Some(a), Some(b)) => is_newer(a, b),
            _ => false,
        };
        if b.worth() < a.worth() || (b.worth() == a.worth() && b_is_older) { Slot::B } else { Slot::A }
    }

    /// Whether the other slot may be written, too, where this one takes nothing.
    pub(super) fn may_write_other(&self, slot: Slot, in_use: Option<Slot>) -> bool {
        let [a, b] = &self.states;
        let state = match slot.other() {
            Slot::A => a,
            Slot::B => b,
        };
        in_use != Some(slot.other()) && state.is_free()
    }

    /// The sequence number of the next record: above the newest in either slot, of unusable records too.
    pub(super) fn next_sequence(&self) -> u32 {
        let newest = self.states.iter().filter_map(SlotState::sequence);
        let newest = newest.reduce(|a, b| if is_newer(b, a) { b } else { a });
        newest.map_or(1, |newest| newest.wrapping_add(1))
    }
}

#[cfg(test)]
mod tests {
    use super::{BothSlots, Slot, SlotState};
    use crate::record::RecordError;

    const EMPTY: SlotState = SlotState::Unusable(RecordError::Empty);
    const TORN: SlotState = SlotState::Unusable(RecordError::Torn);

    fn newer_firmware(sequence: u32) -> SlotState {
        SlotState::Unusable(RecordError::Unsupported { version: 9, sequence })
    }

    #[test]
    fn what_is_overwritten_is_what_is_worth_least() {
        for (states, in_use, target) in [
            ([EMPTY, EMPTY], None, Slot::A),
            ([TORN, EMPTY], None, Slot::B),
            ([newer_firmware(7), TORN], None, Slot::B),
            ([TORN, newer_firmware(7)], None, Slot::A),
            ([newer_firmware(7), newer_firmware(6)], None, Slot::B),
            ([newer_firmware(6), newer_firmware(7)], None, Slot::A),
            ([newer_firmware(7), SlotState::Current(3)], None, Slot::A),
            ([SlotState::Current(3), EMPTY], None, Slot::B),
            ([TORN, SlotState::Stale(3)], Some(Slot::A), Slot::B),
            ([EMPTY, SlotState::Damaged], None, Slot::B),
            ([SlotState::Damaged, newer_firmware(7)], None, Slot::A),
            ([SlotState::Current(3), SlotState::Damaged], None, Slot::B),
            ([SlotState::Damaged, SlotState::Stale(3)], Some(Slot::A), Slot::B),
        ] {
            assert_eq!(BothSlots { states }.target(in_use), target, "{states:?} {in_use:?}");
        }
    }

    #[test]
    fn the_next_number_is_above_that_of_unusable_records_too() {
        for (states, next) in [
            ([EMPTY, TORN], 1),
            ([newer_firmware(7), TORN], 8),
            ([SlotState::Current(3), newer_firmware(9)], 10),
            ([SlotState::Unusable(RecordError::Unsound { sequence: 11 }), SlotState::Current(3)], 12),
            ([SlotState::Current(u32::MAX), SlotState::Stale(u32::MAX - 1)], 0),
        ] {
            assert_eq!(BothSlots { states }.next_sequence(), next, "{states:?}");
        }
    }
}
