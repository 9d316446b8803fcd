// The serial line: bytes take the time that the baud rate says, in both directions, through FIFOs of 32 bytes that can overrun.
// rp2040js passes bytes on at once and its transmit interrupt never clears.

const TRANSMIT = 1 << 5;
const FIFO_BYTES = 32;
/** At half of the FIFO (UARTIFLS after reset). */
const TRANSMIT_LEVEL = 16;
const FLAGS = { busy: 1 << 3, receiveEmpty: 1 << 4, transmitFull: 1 << 5, receiveFull: 1 << 6, transmitEmpty: 1 << 7 };
/** Registers that rp2040js does not have: their values after reset. Reads of all ones would claim errors and DMA. */
const MISSING = { 0x04: 0, 0x20: 0, 0x34: 0x12, 0x48: 0 };

export class SerialLine {
  /** `pending`: bytes on their way to the board, which outlive a reset of it. */
  constructor(uart, mcu, clock, pending, onByte) {
    Object.assign(this, { uart, clock, pending, overruns: 0 });
    const byteNs = () => (uart.baudDivider ? 10e9 / uart.baudRate : 86_806);
    uart.checkInterrupts = () => mcu.setInterrupt(uart.irq, !!(uart.interruptStatus & uart.interruptMask));

    const fifo = [];
    const shiftOut = clock.createAlarm(() => {
      onByte(fifo.shift());
      if (fifo.length === TRANSMIT_LEVEL || fifo.length === 0) {
        uart.interruptStatus |= TRANSMIT;
        uart.checkInterrupts();
      }
      if (fifo.length) shiftOut.schedule(byteNs());
    });
    uart.onByte = (byte) => {
      if (fifo.length < FIFO_BYTES) fifo.push(byte);
      if (!shiftOut.isSet) shiftOut.schedule(byteNs());
    };
    Object.defineProperty(uart, 'flags', {
      get: () =>
        (fifo.length ? FLAGS.busy : FLAGS.transmitEmpty) |
        (fifo.length >= FIFO_BYTES ? FLAGS.transmitFull : 0) |
        (uart.rxFIFO.empty ? FLAGS.receiveEmpty : 0) |
        (uart.rxFIFO.full ? FLAGS.receiveFull : 0),
    });

    const registers = { ...MISSING };
    const [read, write] = [uart.readUint32.bind(uart), uart.writeUint32.bind(uart)];
    uart.readUint32 = (offset) => registers[offset] ?? read(offset);
    uart.writeUint32 = (offset, value) => {
      if (offset in registers) registers[offset] = value;
      else write(offset, value);
    };

    this.arrival = clock.createAlarm(() => {
      if (!this.pending.length) return;
      const byte = this.pending.shift();
      if (uart.rxFIFO.full) this.overruns++;
      else uart.feedByte(byte);
      if (this.pending.length) this.arrival.schedule(byteNs());
    });
    this.byteNs = byteNs;
    this.go();
  }

  send(bytes) {
    this.pending.push(...bytes);
    this.go();
  }

  go() {
    if (this.pending.length && !this.arrival.isSet) this.arrival.schedule(this.byteNs());
  }
}
