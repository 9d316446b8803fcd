//! Volatile access to the board's memory-mapped registers.

/// A 32-bit register at a fixed address.
#[derive(Clone, Copy)]
pub struct Register(*mut u32);

impl Register {
    /// The register `offset` bytes into the peripheral at `base`.
    ///
    /// # Safety
    /// `base + offset` is the word-aligned address of a register of this board whose accesses have no effect on memory
    /// that Rust owns.
    pub const unsafe fn new(base: usize, offset: usize) -> Self {
        Self((base + offset) as *mut u32)
    }

    /// Reads the register.
    #[inline]
    pub fn read(self) -> u32 {
        // SAFETY: `new` was promised the address of a register.
        unsafe { self.0.read_volatile() }
    }

    /// Writes the register.
    #[inline]
    pub fn write(self, value: u32) {
        // SAFETY: `new` was promised the address of a register.
        unsafe { self.0.write_volatile(value) }
    }
}
