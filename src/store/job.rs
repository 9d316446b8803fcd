//! What is done with the two slots, without I/O.

use heapless::Vec;

use super::slot::{BothSlots, Slot, SlotState, StoreError};
use crate::record::{self, DoesNotFit, MAX_RECORD_BYTES, RECORD_BYTES, Record, RecordError, is_newer};

/// The most bytes of one task: a page of the smallest EEPROM, so that a task never waits for two of them.
pub const CHUNK_BYTES: usize = 32;

/// The bytes of one task.
pub type Chunk = Vec<u8, CHUNK_BYTES>;

/// How often a slot is read that looks torn, or written that does not read back: a bus may flip a bit now and then.
const ATTEMPTS: u8 = 3;

/// How often a task that failed is done again, and the pause before: an EEPROM that writes does not answer, for 5 to
/// 10 ms.
const TRIES: u8 = 16;
const PAUSE_MS: u64 = 1;

/// How often both slots are looked at where one of them cannot be read and the other can, and the pause before. A memory that wakes
/// up late, or whose bus is held, fails in both or comes back; what fails each time while the other slot answers before and after
/// it is the cells themselves.
const MOST_REREADS: u8 = 3;
const LOOK_PAUSE_MS: u64 = 50;

/// What has to be done with the memory now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StoreTask {
    /// Read.
    Read {
        /// The slot.
        slot: Slot,
        /// The first byte in it.
        at: usize,
        /// How many, [`CHUNK_BYTES`] at most.
        length: usize,
    },
    /// Write. The first bytes of a slot are written first; flash erases the slot then.
    Write {
        /// The slot.
        slot: Slot,
        /// The first byte in it, a multiple of [`CHUNK_BYTES`].
        at: usize,
        /// What to write.
        bytes: Chunk,
    },
}

/// What came of a [`StoreTask`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StoreAnswer {
    /// All the bytes asked for.
    Read(Chunk),
    /// Written.
    Written,
    /// It failed, perhaps only because the memory was still writing; it will be asked for again.
    Failed,
    /// A write failed half-way in cells that have to be erased before they are written again ([`StoreError::HalfWritten`]): the slot
    /// is begun again.
    HalfWritten,
}

/// What a job came to.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "short-lived, and there is no heap to box it on")]
pub enum Done {
    /// What stands in the slots, and the current record.
    Inspected(BothSlots, Option<Record>),
    /// The record was written here and reads back; its sequence number is the new one.
    Saved(Slot, Record),
    /// Both slots are empty.
    Erased,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Inspect,
    Save { in_use: Option<Slot> },
    Erase,
}

/// What is being done with `slot`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Finding out what it holds.
    Inspecting,
    Writing,
    /// Reading back.
    Confirming,
    Finished(Option<StoreError>),
}

/// One job of the store: inspecting, saving or erasing.
///
/// Where it fails, the record that was current still is, except where the memory took the bytes and only failed to read
/// them back.
#[derive(Debug, Clone)]
pub struct StoreJob {
    purpose: Purpose,
    phase: Phase,
    slot: Slot,
    /// The next byte of the slot, and where the phase ends.
    at: usize,
    end: usize,
    attempts: u8,
    tries: u8,
    /// How often both slots were looked at, and whether one was not read again that had been.
    rereads: u8,
    is_lost: bool,
    /// The slot that was to be written took nothing: this is the other one.
    is_other: bool,
    not_before_ms: u64,
    buffer: [u8; MAX_RECORD_BYTES],
    found: [SlotState; 2],
    /// The current record where that is looked for, the one to save where that is done.
    record: Option<Record>,
}

impl StoreJob {
    const fn new(purpose: Purpose, record: Option<Record>) -> Self {
        Self {
            purpose,
            phase: Phase::Inspecting,
            slot: Slot::A,
            at: 0,
            end: RECORD_BYTES,
            attempts: 0,
            tries: 0,
            rereads: 0,
            is_lost: false,
            is_other: false,
            not_before_ms: 0,
            buffer: [0; MAX_RECORD_BYTES],
            found: [SlotState::Unreadable; 2],
            record,
        }
    }

    /// Finds out what stands in the slots.
    pub const fn inspect() -> Self {
        Self::new(Purpose::Inspect, None)
    }

    /// Writes `record` with the next sequence number into the slot that is not in use, and reads it back. `in_use` is the
    /// slot of the record in use, where the caller knows it: it is not touched, even if it cannot be read properly now. A
    /// memory that does not answer is an error: without knowing what a slot holds, the record in use might be the one overwritten. A
    /// slot whose bytes cannot be read while the other slot answers before and after it, three times in a row, holds nothing
    /// ([`SlotState::Damaged`]) and is written as an empty one.
    pub const fn save(in_use: Option<Slot>, record: Record) -> Self {
        Self::new(Purpose::Save { in_use }, Some(record))
    }

    /// Erases both slots, the one in use last: when power fails between them, the current record still counts.
    pub const fn erase() -> Self {
        Self::new(Purpose::Erase, None)
    }

    /// What has to be done at `now_ms`; the same until it is answered.
    pub fn task(&self, now_ms: u64) -> Option<StoreTask> {
        if now_ms < self.not_before_ms {
            return None;
        }
        let (slot, at) = (self.slot, self.at);
        let length = self.end.saturating_sub(at).min(CHUNK_BYTES);
        match self.phase {
            Phase::Inspecting | Phase::Confirming => Some(StoreTask::Read { slot, at, length }),
            Phase::Writing => {
                let bytes = self.buffer.get(at..at + length).unwrap_or_default();
                // As long as a chunk at most, by `length`.
                Some(StoreTask::Write { slot, at, bytes: Chunk::from_slice(bytes).unwrap_or_default() })
            }
            Phase::Finished(_) => None,
        }
    }

    /// When [`Self::task`] has something to do; `None` once the job is finished.
    pub const fn deadline_ms(&self) -> Option<u64> {
        match self.phase {
            Phase::Finished(_) => None,
            _ => Some(self.not_before_ms),
        }
    }

    /// Whether [`Self::outcome`] is known.
    pub const fn is_finished(&self) -> bool {
        matches!(self.phase, Phase::Finished(_))
    }

    /// What the job came to, once it is finished.
    // Not within its caller, and the record by reference up to its place: inlined, a record of a kilobyte is moved word by word.
    #[inline(never)]
    pub fn outcome(&self) -> Option<Result<Done, StoreError>> {
        let Phase::Finished(error) = self.phase else { return None };
        if let Some(error) = error {
            return Some(Err(error));
        }
        Some(Ok(match (self.purpose, &self.record) {
            (Purpose::Inspect, record) => Done::Inspected(BothSlots { states: self.found }, *record),
            (Purpose::Save { .. }, Some(record)) => Done::Saved(self.slot, *record),
            (Purpose::Erase | Purpose::Save { .. }, _) => Done::Erased,
        }))
    }

    /// Takes what came of the task.
    pub fn complete(&mut self, answer: &StoreAnswer, now_ms: u64) {
        let length = self.end.saturating_sub(self.at).min(CHUNK_BYTES);
        if self.phase == Phase::Writing && *answer == StoreAnswer::HalfWritten {
            self.not_before_ms = now_ms.saturating_add(PAUSE_MS);
            self.write_again(StoreError::Write(self.slot));
            return;
        }
        let done = match (self.phase, answer) {
            (Phase::Writing, StoreAnswer::Written) => true,
            (Phase::Inspecting | Phase::Confirming, StoreAnswer::Read(bytes)) => bytes.len() == length,
            _ => false,
        };
        if !done {
            self.failed(now_ms);
            return;
        }
        self.tries = 0;
        self.not_before_ms = now_ms;
        let chunk = self.at..self.at + length;
        match answer {
            StoreAnswer::Read(bytes) if self.phase == Phase::Confirming => {
                if self.buffer.get(chunk) != Some(bytes.as_slice()) {
                    self.write_again(StoreError::NotConfirmed(self.slot));
                    return;
                }
            }
            StoreAnswer::Read(bytes) => {
                if let Some(place) = self.buffer.get_mut(chunk) {
                    place.copy_from_slice(bytes);
                }
            }
            StoreAnswer::Written | StoreAnswer::Failed | StoreAnswer::HalfWritten => {}
        }
        self.at += length;
        if self.phase == Phase::Inspecting {
            let read = self.buffer.get(..self.at).unwrap_or_default();
            self.end = record::stated_length(read).unwrap_or(RECORD_BYTES).max(self.at);
        }
        if self.at >= self.end {
            self.phase_done();
        }
    }

    fn failed(&mut self, now_ms: u64) {
        self.tries = self.tries.saturating_add(1);
        if self.tries < TRIES {
            self.not_before_ms = now_ms.saturating_add(PAUSE_MS);
            return;
        }
        match self.phase {
            Phase::Inspecting => {
                self.not_before_ms = now_ms;
                self.note(SlotState::Unreadable);
            }
            Phase::Writing => self.give_up(StoreError::Write(self.slot)),
            // Cells that took it and cannot be read are erased and written again.
            Phase::Confirming => self.write_again(StoreError::Read(self.slot)),
            Phase::Finished(_) => {}
        }
    }

    /// Writes the slot again from its first byte, a few times; `why` tells what was wrong.
    fn write_again(&mut self, why: StoreError) {
        self.attempts += 1;
        (self.phase, self.at, self.tries) = (Phase::Writing, 0, 0);
        if self.attempts >= ATTEMPTS {
            self.give_up(why);
        }
    }

    /// The slot takes nothing any more. The other one does, where nothing is lost with it.
    fn give_up(&mut self, why: StoreError) {
        let slots = BothSlots { states: self.found };
        match self.purpose {
            Purpose::Save { in_use } if !self.is_other && slots.may_write_other(self.slot, in_use) => {
                self.is_other = true;
                self.write(self.slot.other());
            }
            _ => self.phase = Phase::Finished(Some(why)),
        }
    }

    fn phase_done(&mut self) {
        match self.phase {
            Phase::Inspecting => self.inspected(),
            Phase::Writing => (self.phase, self.at) = (Phase::Confirming, 0),
            Phase::Confirming if self.purpose == Purpose::Erase && self.other_is_to_be_erased() => {
                self.write(self.slot.other());
            }
            Phase::Confirming => self.phase = Phase::Finished(None),
            Phase::Finished(_) => {}
        }
    }

    /// A slot was read as far as its record goes.
    fn inspected(&mut self) {
        let state = match Record::decode(self.buffer.get(..self.end).unwrap_or_default()) {
            Ok(record) => {
                if self.purpose == Purpose::Inspect && self.is_newest(record.sequence) {
                    self.record = Some(record);
                }
                SlotState::Current(record.sequence)
            }
            // Read again: a bit flipped on the bus must not make the record in use look like one that may be overwritten.
            Err(RecordError::Torn) if self.attempts + 1 < ATTEMPTS => {
                self.attempts += 1;
                (self.at, self.end) = (0, RECORD_BYTES);
                return;
            }
            Err(why) => SlotState::Unusable(why),
        };
        self.note(state);
    }

    fn is_newest(&self, sequence: u32) -> bool {
        self.record.is_none_or(|first| is_newer(sequence, first.sequence))
    }

    /// What a slot holds is known.
    fn note(&mut self, state: SlotState) {
        (self.at, self.end, self.attempts, self.tries) = (0, RECORD_BYTES, 0, 0);
        let [a, b] = &mut self.found;
        let known = match self.slot {
            Slot::A => a,
            Slot::B => b,
        };
        if state == SlotState::Unreadable && *known != SlotState::Unreadable {
            // The memory has gone silent: what was read before is what is there.
            self.is_lost = true;
        } else {
            *known = state;
        }
        if self.slot == Slot::A {
            self.slot = Slot::B;
        } else if !self.rereads_again() {
            self.compare();
            self.act();
        }
    }

    /// Looks at both slots again where one cannot be read and the other can. One that stays so is damaged.
    fn rereads_again(&mut self) -> bool {
        let [a, b] = &mut self.found;
        let unread = match (*a == SlotState::Unreadable, *b == SlotState::Unreadable) {
            (true, false) if !self.is_lost => a,
            (false, true) if !self.is_lost => b,
            _ => return false,
        };
        self.rereads += 1;
        if self.rereads >= MOST_REREADS {
            *unread = SlotState::Damaged;
            return false;
        }
        self.slot = Slot::A;
        self.not_before_ms = self.not_before_ms.saturating_add(LOOK_PAUSE_MS);
        true
    }

    /// Of two sound records the older one is stale.
    fn compare(&mut self) {
        if let [SlotState::Current(first), SlotState::Current(second)] = self.found {
            self.found = if is_newer(second, first) {
                [SlotState::Stale(first), SlotState::Current(second)]
            } else {
                [SlotState::Current(first), SlotState::Stale(second)]
            };
        }
    }

    /// Both slots are known: does what the job is for.
    fn act(&mut self) {
        let slots = BothSlots { states: self.found };
        match self.purpose {
            Purpose::Inspect => self.phase = Phase::Finished(None),
            Purpose::Save { in_use } => {
                if let Some(slot) = slots.unreadable() {
                    self.phase = Phase::Finished(Some(StoreError::Read(slot)));
                    return;
                }
                let Some(record) = &mut self.record else { return };
                record.sequence = slots.next_sequence();
                match record.encode() {
                    Ok(encoded) => {
                        self.end = encoded.as_bytes().len();
                        if let Some(place) = self.buffer.get_mut(..self.end) {
                            place.copy_from_slice(encoded.as_bytes());
                        }
                        self.write(slots.target(in_use));
                    }
                    Err(DoesNotFit) => self.phase = Phase::Finished(Some(StoreError::DoesNotFit)),
                }
            }
            Purpose::Erase => {
                self.buffer = [0xff; MAX_RECORD_BYTES];
                self.end = RECORD_BYTES;
                let last = slots.current().map_or(Slot::B, |(slot, _)| slot);
                self.write(last.other());
            }
        }
    }

    fn write(&mut self, slot: Slot) {
        (self.slot, self.phase, self.at) = (slot, Phase::Writing, 0);
        (self.attempts, self.tries) = (0, 0);
    }

    /// While erasing: whether the slot at hand was the first of the two.
    fn other_is_to_be_erased(&self) -> bool {
        let last = BothSlots { states: self.found }.current().map_or(Slot::B, |(slot, _)| slot);
        self.slot != last
    }
}
