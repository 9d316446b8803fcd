//! Where a calibration is kept: two slots, of which one always holds the last good record.
//!
//! A new record goes into the slot that is *not* in use, and is read back before it counts. Power may fail at
//! any byte of the write: the slot in use was not touched, and the other one is recognised as torn. Of two
//! sound records the one with the newer sequence number is current and the other stale.
//!
//! [`StoreJob`] does that without I/O, a few bytes at a time, so that sampling goes on meanwhile: whoever owns the memory does
//! each [`StoreTask`] and gives the [`StoreAnswer`] back. [`Store`] is memory that is waited for, [`serve`] does a task with
//! it, and [`run`] a whole job.

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
