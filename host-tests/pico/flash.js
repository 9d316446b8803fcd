// The flash chip: sectors of 4 KiB erase to ones, programming only clears bits, and power may fail in the middle of either.

export const SECTOR = 4096;
export const PAGE = 256;
/** W25Q16JV, typical: a sector erased, a page programmed. */
const ERASE_NS = 45e6;
const PROGRAM_NS = 0.4e6;

export class PowerCut extends Error {}

export class Flash {
  constructor(bytes) {
    // rp2040js maps 16 MiB; a Pico has the first two of them.
    this.memory = new Uint8Array(16 << 20).fill(0xff);
    Object.assign(this, { bytes, operations: 0, erased: new Map(), cutAt: Infinity, seed: 0, pass: () => {} });
  }

  /** Power fails during operation number `after` from now on (0: the next), at a point that `seed` decides. */
  cut(after, seed) {
    this.cutAt = this.operations + after;
    this.seed = seed;
  }

  /** Numbers from 0 to 1 that depend on the seed only (mulberry32). */
  random() {
    this.seed = (this.seed + 0x6d2b79f5) | 0;
    let t = Math.imul(this.seed ^ (this.seed >>> 15), this.seed | 1);
    t = (t + Math.imul(t ^ (t >>> 7), t | 61)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  }

  check(at, length, unit, what) {
    if (at % unit || length % unit || at + length > this.bytes) {
      throw new Error(`${what} of ${length} bytes at 0x${at.toString(16)}: not whole units of ${unit} inside the flash`);
    }
  }

  erase(at, length) {
    this.check(at, length, SECTOR, 'an erase');
    for (let sector = at; sector < at + length; sector += SECTOR) {
      if (this.operations++ >= this.cutAt) {
        // Cells on their way to one: from hardly any to nearly all of them have arrived.
        const arrived = this.random();
        for (let i = sector; i < sector + SECTOR; i++) {
          for (let bit = 0; bit < 8; bit++) if (this.random() < arrived) this.memory[i] |= 1 << bit;
        }
        throw new PowerCut('while a sector was being erased');
      }
      this.memory.fill(0xff, sector, sector + SECTOR);
      this.erased.set(sector, (this.erased.get(sector) ?? 0) + 1);
      this.pass(ERASE_NS);
    }
  }

  program(at, length, byte) {
    this.check(at, length, PAGE, 'a program');
    for (let page = 0; page < length; page += PAGE) {
      const isCut = this.operations++ >= this.cutAt;
      const whole = isCut ? Math.floor(this.random() * PAGE) : PAGE;
      for (let i = page; i < page + whole; i++) this.memory[at + i] &= byte(i);
      if (isCut) {
        // The byte that was being written has some of its zeros.
        const last = page + whole;
        this.memory[at + last] &= byte(last) | Math.floor(this.random() * 256);
        throw new PowerCut('while a page was being programmed');
      }
      this.pass(PROGRAM_NS);
    }
  }
}
