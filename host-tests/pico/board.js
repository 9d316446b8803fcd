// A Raspberry Pi Pico: rp2040js with what it lacks of a board that runs a firmware as it is flashed. The boot, resets that keep
// the memory, hard faults, a flash chip that loses power, and buses that take time. One of its two cores is emulated.
import { RP2040 } from 'rp2040js';
import { ROM_BYTES, STAGE2, bootrom, call, isStage2Sound } from './bootrom.js';
import { Clock } from './clock.js';
import { Flash } from './flash.js';
import { I2cBus } from './i2c.js';
import { load } from './image.js';
import { SerialLine } from './uart.js';
import { UsbCable } from './usb.js';

const FLASH_BASE = 0x10000000;
const FLASH_BYTES = 2 << 20;
const SRAM_BASE = 0x20000000;
/** Numbers in `mcu.peripherals`: addresses without their lowest 12 bits. */
const PERIPHERAL = { xipControl: 0x14000, resets: 0x4000c, watchdog: 0x40058 };
const RESET_I2C = [1 << 3, 1 << 4];
const HARD_FAULT = 3;
const NMI = 2;
const AIRCR = 0xd0c;
const AIRCR_KEY = 0x05fa;
const SYSRESETREQ = 1 << 2;

/** The core can do nothing more: a fault in the handler of a fault. */
export class Lockup extends Error {}
class Fault extends Error {}
class Reset extends Error {
  constructor(cause, reason) {
    super(cause);
    this.reason = reason;
  }
}
// They are thrown in the middle of instructions, and nobody looks at where.
Error.stackTraceLimit = 0;

export class Board {
  /** `events`: `i2c(bus, event)` answers an event on a bus; `byte(port, byte)` and `pin(index, level)` are told. */
  constructor(image, events) {
    this.events = events;
    this.flash = new Flash(FLASH_BYTES);
    for (const { address, bytes } of load(image)) {
      if (address >= FLASH_BASE && address < FLASH_BASE + FLASH_BYTES) this.flash.memory.set(bytes, address - FLASH_BASE);
    }
    this.inputs = new Map();
    this.counts = { instructions: 0, cycles: 0 };
    this.resets = [];
    this.warnings = new Map();
    this.nsBefore = 0;
    this.at = 0;
    this.watched = null;
    this.lastFault = null;
    this.powerOn();
  }

  /** Time since the board was made, over resets and power cuts. */
  get nanos() {
    return this.nsBefore + this.clock.nanos;
  }

  powerOn() {
    this.sram = null;
    this.waiting = { uart: [], usb: [] };
    this.flash.cutAt = Infinity;
    this.boot(0, null);
  }

  boot(reason, scratch) {
    if (this.mcu) {
      this.nsBefore += this.clock.nanos;
      this.counts.cycles += this.mcu.core.cycles;
    }
    // A new chip at each reset: rp2040js's own erases the flash or keeps the core's state.
    const clock = (this.clock = new Clock());
    const mcu = (this.mcu = new RP2040(clock));
    clock.core = mcu.core;
    mcu.flash = this.flash.memory;
    mcu.flash16 = new Uint16Array(this.flash.memory.buffer);
    mcu.flashView = new DataView(this.flash.memory.buffer);
    if (this.sram) mcu.sram.set(this.sram);
    this.sram = mcu.sram;
    mcu.bootrom.set(bootrom());
    mcu.addClockListener((hz) => clock.setFrequency(hz));
    clock.setFrequency(mcu.clkSys);
    this.flash.pass = (ns) => clock.pass(ns);
    this.faultOnWrongAccesses(mcu);
    this.addMissingRegisters(mcu, reason, scratch);
    mcu.onBreak = (code) => this.breakpoint(code);
    this.uart = new SerialLine(mcu.uart[0], mcu, clock, this.waiting.uart, (byte) => this.events.byte('uart', byte));
    this.usb = new UsbCable(mcu, clock, this.waiting.usb, (byte) => this.events.byte('usb', byte));
    this.i2c = mcu.i2c.map((block, bus) => new I2cBus(block, mcu, clock, (event) => this.events.i2c(bus, event)));
    for (const pin of mcu.gpio) {
      // Nothing drives it: a pull-up does.
      pin.setInputValue(this.inputs.get(pin.index) ?? true);
      pin.addListener(() => this.events.pin(pin.index, pin.outputEnable ? pin.outputValue : null));
    }
    if (!isStage2Sound(this.flash.memory)) throw new Error('the second stage of the boot is not sound: the chip would wait for USB');
    mcu.sram.set(this.flash.memory.subarray(0, 256), STAGE2 - SRAM_BASE);
    Object.assign(mcu.core, { SP: STAGE2, LR: 0, PC: STAGE2 });
  }

  /** rp2040js only logs what makes a real core fault, and a SEV. */
  faultOnWrongAccesses(mcu) {
    mcu.logger = {
      debug() {},
      info: (_, text) => {
        if (text === 'SEV') mcu.core.eventRegistered = true;
      },
      warn: (who, text) => {
        if (who === 'RP2040' || who === 'CortexM0Core') throw new Fault(text);
        const warning = `${who}: ${text}`;
        this.warnings.set(warning, (this.warnings.get(warning) ?? 0) + 1);
      },
      error: (who, text) => {
        throw new Fault(`${who}: ${text}`);
      },
    };
    const aligned = (address, mask, what) => {
      if (address & mask) throw new Fault(`unaligned ${what} at 0x${(address >>> 0).toString(16)}`);
    };
    mcu.core.writeUint32 = (address, value) => {
      aligned(address, 3, 'write');
      mcu.writeUint32(address, value);
    };
    mcu.core.readUint16 = (address) => {
      aligned(address, 1, 'read');
      return mcu.readUint16(address);
    };
  }

  addMissingRegisters(mcu, reason, scratch) {
    const { ppb } = mcu;
    const [read, write] = [ppb.readUint32.bind(ppb), ppb.writeUint32.bind(ppb)];
    ppb.readUint32 = (offset) => (offset === AIRCR ? AIRCR_KEY << 16 : read(offset));
    ppb.writeUint32 = (offset, value) => {
      if (offset !== AIRCR) write(offset, value);
      else if (value >>> 16 === AIRCR_KEY && value & SYSRESETREQ) throw new Reset('SYSRESETREQ', 0);
    };
    // Of the cache's control: enabled, and its stream is idle.
    const xip = { 0x00: 3, 0x08: 3 };
    mcu.peripherals[PERIPHERAL.xipControl] = { readUint32: (offset) => xip[offset & 0xff] ?? 0, writeUint32Atomic() {} };
    const resets = mcu.peripherals[PERIPHERAL.resets];
    const writeResets = resets.writeUint32.bind(resets);
    resets.writeUint32 = (offset, value) => {
      writeResets(offset, value);
      if (offset === 0) RESET_I2C.forEach((bit, bus) => value & bit && this.i2c[bus].reset());
    };
    const watchdog = mcu.peripherals[PERIPHERAL.watchdog];
    watchdog.reason = reason;
    if (scratch) watchdog.scratchData.set(scratch);
    watchdog.onWatchdogTrigger = () => {
      throw new Reset('watchdog', watchdog.reason);
    };
  }

  breakpoint(code) {
    const { mcu } = this;
    const at = mcu.core.PC - 2;
    const opcode = mcu.readUint16(at);
    if (opcode >>> 8 === 0xde || opcode >>> 4 === 0xf7f) throw new Fault('undefined instruction');
    if (at >= ROM_BYTES) throw new Fault(`bkpt ${code}`);
    call(code, mcu.core.registers, mcu, this.flash);
  }

  /** Sets what the world does to a pin: true, false, or null for nothing (a pull-up). */
  drive(pin, level) {
    this.inputs.set(pin, level ?? true);
    this.mcu.gpio[pin].setInputValue(level ?? true);
  }

  send(port, bytes) {
    this[port].send(bytes);
  }

  /** Runs for so many nanoseconds, or until `enough()`. */
  run(ns, enough) {
    const end = this.nanos + ns;
    while (this.nanos < end && !enough()) {
      try {
        this.execute(end - this.nsBefore, enough);
      } catch (event) {
        if (event instanceof Fault) this.hardFault(event);
        else if (event instanceof Reset) {
          this.resets.push({ cause: event.message, ns: this.nanos });
          this.boot(event.reason, this.mcu.peripherals[PERIPHERAL.watchdog].scratchData);
        } else throw event;
      }
    }
  }

  execute(endNs, enough) {
    const { clock, mcu } = this;
    const { core } = mcu;
    while (clock.nanos < endNs && !enough()) {
      if (core.waiting) {
        // What became pending while PRIMASK was set ends a WFI at once (ARMv6-M, B1.5.19); rp2040js looks for what comes later only.
        if (core.pendingInterrupts & core.enabledInterrupts) core.waiting = false;
        else clock.sleep(endNs);
        continue;
      }
      // Some milliseconds at once, no further than the next alarm, and one instruction at least: rounding may put the end of the
      // time at a cycle that has been.
      const stop = Math.max(core.cycles + 1, Math.min(clock.cyclesAt(endNs), core.cycles + 100_000));
      let executed = 0;
      try {
        while (!core.waiting && core.cycles < stop && core.cycles < clock.dueCycles) {
          this.at = core.PC;
          if (this.watched) this.observe(core);
          core.executeInstruction();
          executed++;
        }
      } finally {
        this.counts.instructions += executed;
      }
      if (core.cycles >= clock.dueCycles) clock.fire();
    }
  }

  /** Counts the calls of the function at `address` from now on, and the cycles of each: those of interrupts in it too. */
  watch(address) {
    this.watched = { address, calls: 0, cycles: 0, worst: 0, since: null, back: 0, sp: 0 };
  }

  observe(core) {
    const { watched } = this;
    if (watched.since === null) {
      if (core.PC === watched.address) Object.assign(watched, { since: core.cycles, back: core.LR & ~1, sp: core.SP });
    } else if (core.PC === watched.back && core.SP === watched.sp) {
      const cycles = core.cycles - watched.since;
      watched.calls++;
      watched.cycles += cycles;
      watched.worst = Math.max(watched.worst, cycles);
      watched.since = null;
    }
  }

  hardFault(fault) {
    const { core } = this.mcu;
    this.lastFault = fault.message;
    if (core.IPSR === HARD_FAULT || core.IPSR === NMI) throw new Lockup(`a fault in the handler of a fault: ${fault.message}`);
    // rp2040js may have stepped over the instruction already.
    core.PC = this.at;
    core.exceptionEntry(HARD_FAULT);
    core.PC &= ~1;
  }

  state() {
    const { core } = this.mcu;
    return {
      ns: this.nanos,
      cycles: this.counts.cycles + core.cycles,
      instructions: this.counts.instructions,
      resets: this.resets,
      fault: this.lastFault,
      overruns: this.uart.overruns,
      operations: this.flash.operations,
      erased: [...this.flash.erased],
      warnings: Object.fromEntries(this.warnings),
      watched: this.watched && { calls: this.watched.calls, cycles: this.watched.cycles, worst: this.watched.worst },
    };
  }
}
