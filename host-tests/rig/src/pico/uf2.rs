//! UF2: what is copied onto a Pico that shows itself as a drive (`BOOTSEL` held while it is plugged in).
//!
//! Format: "USB Flashing Format (UF2)", Microsoft; the blocks of 256 bytes and the family are those of the RP2040's datasheet,
//! 2.8.4.2.

use super::error::Error;
use object::LittleEndian;
use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};
use std::collections::BTreeMap;
use std::path::Path;

const FLASH: std::ops::Range<u32> = 0x1000_0000..0x1100_0000;
const PAGE_BYTES: u32 = 256;
const BLOCK_BYTES: usize = 512;
const MAGIC: [u32; 2] = [0x0A32_4655, 0x9E5D_5157];
const MAGIC_END: u32 = 0x0AB1_6F30;
/// The family's number is given.
const FLAGS: u32 = 0x2000;
const RP2040: u32 = 0xE48B_FF56;

/// The UF2 image of an ELF for the RP2040.
///
/// # Errors
/// [`Error::Io`]; [`Error::Image`] where the file is no such ELF.
pub fn uf2(elf: &Path) -> Result<Vec<u8>, Error> {
    let bytes = std::fs::read(elf).map_err(Error::io(format!("read {}", elf.display())))?;
    let wrong = |reason: String| Error::Image { path: elf.to_owned(), reason };
    let pages = pages(&bytes).map_err(|error| wrong(format!("it is no ELF of 32 bits: {error}")))?;
    if pages.is_empty() {
        return Err(wrong("it holds nothing for the flash of an RP2040".to_owned()));
    }
    let count = pages.len() as u32;
    let blocks = pages.into_iter().zip(0_u32..).flat_map(|((address, page), number)| {
        let head = [MAGIC[0], MAGIC[1], FLAGS, address, PAGE_BYTES, number, count, RP2040];
        let mut block: Vec<u8> = head.into_iter().flat_map(u32::to_le_bytes).chain(page).collect();
        block.resize(BLOCK_BYTES - 4, 0);
        block.extend(MAGIC_END.to_le_bytes());
        block
    });
    Ok(blocks.collect())
}

/// The flash's pages that the file fills, by their addresses; what it leaves out of a page is as erased.
fn pages(bytes: &[u8]) -> Result<BTreeMap<u32, Vec<u8>>, String> {
    let said = |error: object::read::Error| error.to_string();
    let header = FileHeader32::<LittleEndian>::parse(bytes).map_err(said)?;
    let mut pages = BTreeMap::new();
    for segment in header.program_headers(LittleEndian, bytes).map_err(said)? {
        // The physical address is where it is stored; initial values of statics are copied from there.
        let at = segment.p_paddr(LittleEndian);
        if segment.p_type(LittleEndian) != PT_LOAD || !FLASH.contains(&at) {
            continue;
        }
        let data =
            segment.data(LittleEndian, bytes).map_err(|()| "a segment ends beyond the file".to_owned())?;
        for (&byte, address) in data.iter().zip(at..) {
            let page = pages
                .entry(address - address % PAGE_BYTES)
                .or_insert_with(|| vec![0xFF; PAGE_BYTES as usize]);
            page[(address % PAGE_BYTES) as usize] = byte;
        }
    }
    Ok(pages)
}
