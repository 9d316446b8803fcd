// What one flashes, read as a boot loader would: ELF by load address, UF2 block by block.
import { readFileSync } from 'node:fs';

const ELF_MAGIC = 0x464c457f;
const ELF_LOAD = 1;
const UF2_MAGIC = [0x0a324655, 0x9e5d5157];
const UF2_NOT_MAIN_FLASH = 1;
const RP2040_FAMILY = 0xe48bff56;

/** The bytes of an image by their addresses: `[{ address, bytes }]`. */
export function load(path) {
  const file = readFileSync(path);
  const parts = file.readUInt32LE(0) === ELF_MAGIC ? readElf(file) : readUf2(file);
  if (parts.length === 0) throw new Error(`${path} holds nothing for the flash`);
  return parts;
}

function readElf(file) {
  const [table, entryBytes, entries] = [file.readUInt32LE(28), file.readUInt16LE(42), file.readUInt16LE(44)];
  const parts = [];
  for (let i = 0; i < entries; i++) {
    const [type, offset, , address, length] = [0, 4, 8, 12, 16].map((at) => file.readUInt32LE(table + i * entryBytes + at));
    if (type === ELF_LOAD && length > 0) parts.push({ address, bytes: file.subarray(offset, offset + length) });
  }
  return parts;
}

function readUf2(file) {
  const parts = [];
  for (let at = 0; at + 512 <= file.length; at += 512) {
    const word = (index) => file.readUInt32LE(at + 4 * index);
    if (word(0) !== UF2_MAGIC[0] || word(1) !== UF2_MAGIC[1]) throw new Error(`neither ELF nor UF2: block ${at / 512}`);
    if (word(2) & UF2_NOT_MAIN_FLASH) continue;
    if (word(7) !== RP2040_FAMILY) throw new Error('a UF2 image for another chip');
    parts.push({ address: word(3), bytes: file.subarray(at + 32, at + 32 + word(4)) });
  }
  return parts;
}
