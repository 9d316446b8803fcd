//! A flash with error correction, as of the STM32 G4, H7, L4 and U5: a word takes one programming after an erase, and one whose
//! programming was cut short cannot be read until it is erased.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// What is in the cells after power failed in the middle of an erase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TornErase {
    /// No word of the sector can be read.
    Unreadable,
    /// Every other word is erased, the others cannot be read.
    Half,
    /// All words are as they were.
    Old,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word<const WORD: usize> {
    Erased,
    Programmed([u8; WORD]),
    Unreadable,
}

/// The flash: words of `WORD` bytes that are read, written and corrected as one, in sectors.
#[derive(Clone, Debug)]
pub struct EccFlash<const WORD: usize> {
    words: Vec<Word<WORD>>,
    /// What a sector is like whose erase was cut short.
    pub torn_erase: TornErase,
    /// Words programmed and sectors erased until power fails in the middle of one.
    operations_left: usize,
    /// Words programmed and sectors erased since power-up.
    pub operations: usize,
    /// A sector that takes no erase any more.
    worn_sector: Option<usize>,
    is_dead: bool,
}

/// Bytes of a sector.
pub const SECTOR_BYTES: usize = 2048;

impl<const WORD: usize> EccFlash<WORD> {
    const WORDS_PER_SECTOR: usize = SECTOR_BYTES / WORD;

    /// An erased one.
    pub fn new(sectors: usize) -> Self {
        Self {
            words: vec![Word::Erased; sectors * Self::WORDS_PER_SECTOR],
            torn_erase: TornErase::Unreadable,
            operations_left: usize::MAX,
            operations: 0,
            worn_sector: None,
            is_dead: false,
        }
    }

    /// Power fails in the middle of the operation (a word programmed, a sector erased) after so many more.
    pub fn lose_power_after(&mut self, operations: usize) {
        self.operations_left = operations;
    }

    /// Power is back: what is in the cells is what is there.
    pub fn power_cycle(&mut self) {
        (self.operations_left, self.operations, self.is_dead) = (usize::MAX, 0, false);
    }

    /// From now on this sector is not erased any more.
    pub fn wear_out(&mut self, sector: usize) {
        self.worn_sector = Some(sector);
    }

    /// Whether the operation that begins now is done; power fails in the middle of one that is not.
    fn goes_through(&mut self) -> Result<bool, EccError> {
        if self.is_dead {
            return Err(EccError(NorFlashErrorKind::Other));
        }
        self.operations += 1;
        self.is_dead = self.operations_left == 0;
        self.operations_left = self.operations_left.saturating_sub(1);
        Ok(!self.is_dead)
    }
}

/// A flash that fails.
#[derive(Debug)]
pub struct EccError(NorFlashErrorKind);

const FAILED: EccError = EccError(NorFlashErrorKind::Other);

impl NorFlashError for EccError {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl<const WORD: usize> ErrorType for EccFlash<WORD> {
    type Error = EccError;
}

impl<const WORD: usize> ReadNorFlash for EccFlash<WORD> {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), EccError> {
        check_read(self, offset, bytes.len()).map_err(EccError)?;
        if self.is_dead {
            return Err(FAILED);
        }
        let words = self.words.iter().skip(offset as usize / WORD);
        for (to, word) in bytes.chunks_exact_mut(WORD).zip(words) {
            match word {
                Word::Erased => to.fill(0xFF),
                Word::Programmed(value) => to.copy_from_slice(value),
                Word::Unreadable => return Err(FAILED),
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.words.len() * WORD
    }
}

impl<const WORD: usize> NorFlash for EccFlash<WORD> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR_BYTES;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), EccError> {
        check_erase(self, from, to).map_err(EccError)?;
        for sector in from as usize / SECTOR_BYTES..to as usize / SECTOR_BYTES {
            if self.worn_sector == Some(sector) {
                return Err(FAILED);
            }
            let is_done = self.goes_through()?;
            let torn = self.torn_erase;
            let words = &mut self.words[sector * Self::WORDS_PER_SECTOR..][..Self::WORDS_PER_SECTOR];
            for (index, word) in words.iter_mut().enumerate() {
                match torn {
                    _ if is_done => *word = Word::Erased,
                    TornErase::Half if index % 2 == 0 => *word = Word::Erased,
                    TornErase::Half | TornErase::Unreadable => *word = Word::Unreadable,
                    TornErase::Old => {}
                }
            }
            if !is_done {
                return Err(FAILED);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), EccError> {
        check_write(self, offset, bytes.len()).map_err(EccError)?;
        for (index, value) in bytes.chunks_exact(WORD).enumerate() {
            let is_done = self.goes_through()?;
            let word = &mut self.words[offset as usize / WORD + index];
            let is_erased = *word == Word::Erased;
            *word = match value.try_into() {
                Ok(value) if is_done && is_erased => Word::Programmed(value),
                _ => Word::Unreadable,
            };
            if !(is_done && is_erased) {
                return Err(FAILED);
            }
        }
        Ok(())
    }
}
