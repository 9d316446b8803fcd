//! Where a calibration is kept: two slots, of which one always holds the last good record.
//!
//! A new record goes into the slot that is *not* in use, and is read back before it counts. Power may fail at
//! any byte of the write: the slot in use was not touched, and the other one is recognised as torn. Of two
//! sound records the one with the newer sequence number is current and the other stale.
//!
//! [`StoreJob`] does that without I/O, a few bytes at a time, so that sampling goes on meanwhile: whoever owns the memory does
//! each [`StoreTask`] and gives the [`StoreAnswer`] back. [`Store`] is memory that is waited for, [`serve`] does a task with
//! it, and [`run`] a whole job.
//!
//! ```
//! use ironout::record::MAX_RECORD_BYTES;
//! use ironout::store::{Done, Slot, Store, StoreError, StoreJob, run};
//!
//! /// Here it is RAM. For an EEPROM there is `StorageSlots`, for flash `FlashSlots`.
//! struct Memory([[u8; MAX_RECORD_BYTES]; 2]);
//!
//! impl Store for Memory {
//!     fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
//!         let kept = self.0[usize::from(slot == Slot::B)].get(at..at + bytes.len());
//!         bytes.copy_from_slice(kept.ok_or(StoreError::Read(slot))?);
//!         Ok(())
//!     }
//!     fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
//!         let kept = self.0[usize::from(slot == Slot::B)].get_mut(at..at + bytes.len());
//!         kept.ok_or(StoreError::Write(slot))?.copy_from_slice(bytes);
//!         Ok(())
//!     }
//! }
//!
//! # fn main() -> Result<(), StoreError> {
//! # use ironout::{sensor::{Sample, Sensor}, session::{Session, SessionConfig}};
//! # let mut session = Session::new(SessionConfig::of(&Sensor::uniform("a chip", 0.1, 50.0)));
//! # session.start();
//! # for i in 0..1500 {
//! #     let (tilt, turn) = (i as f64 * 0.013, i as f64 * 0.11);
//! #     let field = [tilt.cos() * turn.cos(), tilt.cos() * turn.sin(), tilt.sin()].map(|v| 500.0 * v);
//! #     session.push(Sample::valid([field[0] as i16 + 930, field[1] as i16 - 120, (1.1 * field[2]) as i16 + 45]));
//! # }
//! # session.stop().expect("collecting");
//! let mut memory = Memory([[0xff; MAX_RECORD_BYTES]; 2]);
//! let wait_ms = |_ms: u64| (); // a board sleeps here
//! // At the start: nothing is stored yet.
//! let Done::Inspected(slots, stored) = run(StoreJob::inspect(), &mut memory, wait_ms)? else { unreachable!() };
//! assert!(stored.is_none());
//! // After a calibration:
//! let record = session.accept().expect("accepted");
//! let in_use = slots.current().map(|(slot, _)| slot);
//! run(StoreJob::save(in_use, record), &mut memory, wait_ms)?;
//! // At the next start:
//! let Done::Inspected(_, stored) = run(StoreJob::inspect(), &mut memory, wait_ms)? else { unreachable!() };
//! assert_eq!(stored.expect("it is there").calibration, record.calibration);
//! # Ok(())
//! # }
//! ```

mod flash;
mod job;
mod memory;
mod slot;
#[cfg(all(test, feature = "effects"))]
mod tests;

pub use flash::FlashSlots;
pub use job::{CHUNK_BYTES, Chunk, Done, StoreAnswer, StoreJob, StoreTask};
pub use memory::{BadPlace, StorageSlots, Store, run, serve};
pub use slot::{BothSlots, Slot, SlotState, StoreError};
