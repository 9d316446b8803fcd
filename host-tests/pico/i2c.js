// An I²C bus with the time that its bits take. Whoever holds the chips answers each event: `ask(event)` gives `{ ack }` or
// `{ value }`, and may make it come late (`lateNs`) or never (`hang`), as a chip does that holds the clock low.
import { I2CMode } from 'rp2040js';

const TX_EMPTY = 1 << 4;
const REGISTER = { intrMask: 0x30, sdaHold: 0x7c };
const IDLE = 0;

export class I2cBus {
  constructor(i2c, mcu, clock, ask) {
    const bitNs = () => ((i2c.sclHighPeriod + i2c.sclLowPeriod + i2c.spikelen + 8) * 1e9) / mcu.clkSys;
    let then = null;
    const timer = clock.createAlarm(() => then());
    const play = (event, bits, done) => {
      const answer = ask(event) ?? {};
      if (answer.hang) return;
      then = () => done(answer);
      timer.schedule(bits * bitNs() + (answer.lateNs ?? 0));
    };

    // rp2040js cannot write the interrupts' mask, without which no transfer behind interrupts completes.
    const write = i2c.writeUint32.bind(i2c);
    i2c.writeUint32 = (offset, value) => {
      if (offset === REGISTER.intrMask) {
        i2c.intEnable = value & 0x1fff;
        i2c.checkInterrupts();
      } else if (offset !== REGISTER.sdaHold) write(offset, value);
    };
    // "Empty" means that the last byte has left, and is said after an abort too (IC_CON.TX_EMPTY_CTRL); rp2040js says it too
    // early or never.
    let moving = false;
    const [setInterrupts, abort] = [i2c.setInterrupts.bind(i2c), i2c.abort.bind(i2c)];
    i2c.setInterrupts = (mask) => setInterrupts(moving && i2c.txFIFO.empty ? mask & ~TX_EMPTY : mask);
    i2c.abort = (reason) => {
      abort(reason);
      setInterrupts(TX_EMPTY);
    };
    const moved = (complete) => {
      moving = false;
      complete();
      if (!moving && i2c.txFIFO.itemCount <= i2c.txThreshold) setInterrupts(TX_EMPTY);
    };

    // A start is part of the address that follows it, and chips see them as one.
    i2c.onStart = () => {
      then = () => i2c.completeStart();
      timer.schedule(bitNs());
    };
    i2c.onConnect = (address, mode) =>
      play({ i2c: 'start', address, read: mode === I2CMode.Read }, 9, ({ ack }) => i2c.completeConnect(!!ack));
    i2c.onWriteByte = (value) => {
      moving = true;
      play({ i2c: 'write', value }, 9, ({ ack }) => moved(() => i2c.completeWrite(!!ack)));
    };
    i2c.onReadByte = () => {
      moving = true;
      play({ i2c: 'read' }, 9, ({ value }) => moved(() => i2c.completeRead(value ?? 0xff)));
    };
    i2c.onStop = () => play({ i2c: 'stop' }, 1, () => i2c.completeStop());

    /** The reset of the block: whatever it was doing is forgotten. */
    this.reset = () => {
      timer.cancel();
      moving = false;
      Object.assign(i2c, { state: IDLE, busy: false, stop: false, pendingRestart: false, firstByte: false });
      Object.assign(i2c, { enable: 0, intRaw: 0, intEnable: 0, abortSource: 0, rxThreshold: 0, txThreshold: 0 });
      i2c.txFIFO.reset();
      i2c.rxFIFO.reset();
      i2c.checkInterrupts();
    };
  }
}
