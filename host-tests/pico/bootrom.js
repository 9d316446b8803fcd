// A boot ROM of our own: nothing of the chip's is copied. The tables stand where the RP2040's datasheet, 2.8.3, puts them, and
// every function is `bkpt #index; bx lr`, carried out by the emulator.

/** The functions by index; 0 looks up an entry of the table, the others are named by their codes of two letters. */
export const FUNCTIONS = ['lookup', 'IF', 'EX', 'RE', 'RP', 'FC', 'CX', 'C4', 'MC', 'MS', 'S4', 'P3', 'R3', 'L3', 'T3', 'UB'];

/** Where the ROM ends. */
export const ROM_BYTES = 0x4000;

/** Where the second stage of the boot is copied to and run: the end of the RAM. */
export const STAGE2 = 0x20041f00;

const CODE = 0x200;
const TABLE = 0x100;
const DATA_TABLE = 0x1f0;

export function bootrom() {
  const rom = new DataView(new ArrayBuffer(ROM_BYTES));
  const pointer = (index) => (CODE + 4 * index) | 1;
  rom.setUint32(0, STAGE2, true);
  rom.setUint32(4, pointer(0), true);
  // "Mu", version 1 … of the table's layout, then its revision.
  [0x4d, 0x75, 0x01, 0x03].forEach((byte, i) => rom.setUint8(0x10 + i, byte));
  [TABLE, DATA_TABLE, pointer(0)].forEach((value, i) => rom.setUint16(0x14 + 2 * i, value, true));
  FUNCTIONS.forEach((name, index) => {
    rom.setUint16(CODE + 4 * index, 0xbe00 | index, true);
    rom.setUint16(CODE + 4 * index + 2, 0x4770, true);
    if (index === 0) return;
    rom.setUint8(TABLE + 4 * (index - 1), name.charCodeAt(0));
    rom.setUint8(TABLE + 4 * (index - 1) + 1, name.charCodeAt(1));
    rom.setUint16(TABLE + 4 * (index - 1) + 2, pointer(index), true);
  });
  return new Uint32Array(rom.buffer);
}

/** Whether the first 256 bytes of the flash are a second stage that the chip would run: CRC-32/MPEG-2 over 252 bytes. */
export function isStage2Sound(flash) {
  let crc = 0xffffffff;
  for (const byte of flash.subarray(0, 252)) {
    crc ^= byte << 24;
    for (let bit = 0; bit < 8; bit++) crc = crc & 0x80000000 ? (crc << 1) ^ 0x04c11db7 : crc << 1;
  }
  return crc >>> 0 === new DataView(flash.buffer, flash.byteOffset).getUint32(252, true);
}

/** Carries out ROM function `index`: arguments and result in `r`, the core's registers. */
export function call(index, r, mcu, flash) {
  const name = FUNCTIONS[index];
  switch (name) {
    case 'lookup':
      for (let entry = r[0]; mcu.readUint16(entry); entry += 4) {
        if (mcu.readUint16(entry) === (r[1] & 0xffff)) {
          r[0] = mcu.readUint16(entry + 2);
          return;
        }
      }
      throw new Error(`the ROM has no function ${String.fromCharCode(r[1] & 0xff, (r[1] >> 8) & 0xff)}`);
    case 'RE':
      return flash.erase(r[0] >>> 0, r[1] >>> 0);
    case 'RP':
      return flash.program(r[0] >>> 0, r[2] >>> 0, (i) => mcu.readUint8((r[1] + i) >>> 0));
    case 'C4':
    case 'MC':
      for (let i = 0; i < r[2]; i++) mcu.writeUint8((r[0] + i) >>> 0, mcu.readUint8((r[1] + i) >>> 0));
      return;
    case 'MS':
    case 'S4':
      for (let i = 0; i < r[2]; i++) mcu.writeUint8((r[0] + i) >>> 0, r[1] & 0xff);
      return;
    case 'P3':
      r[0] = [...Array(32).keys()].filter((bit) => (r[0] >>> bit) & 1).length;
      return;
    case 'R3':
      r[0] = [...Array(32).keys()].reduce((word, bit) => word | (((r[0] >>> bit) & 1) << (31 - bit)), 0);
      return;
    case 'L3':
      r[0] = Math.clz32(r[0]);
      return;
    case 'T3':
      r[0] = r[0] ? 31 - Math.clz32(r[0] & -r[0]) : 32;
      return;
    case 'UB':
      throw new Error('the firmware asks for the USB boot loader');
    default:
      // Connecting the flash, leaving and entering execution in place, flushing the cache: there is nothing to do.
      return;
  }
}
