//! Where the device writes.

use core::fmt;

/// The most bytes that a reply takes: that of `cal show` with four effects. A buffer of this size never cuts one.
pub const MAX_REPLY_BYTES: usize = 3072;

/// A place for what the console sends. Writing never waits.
pub trait Output: fmt::Write {
    /// Whether so many bytes can be written without loss. Until it is so, commands wait and lines of a stream are left
    /// out. An empty buffer smaller than that says `true` too, or nothing would ever be answered.
    fn takes(&self, bytes: usize) -> bool;
}

impl<const N: usize> Output for heapless::String<N> {
    fn takes(&self, bytes: usize) -> bool {
        self.is_empty() || N - self.len() >= bytes
    }
}

impl<O: Output + ?Sized> Output for &mut O {
    fn takes(&self, bytes: usize) -> bool {
        (**self).takes(bytes)
    }
}
