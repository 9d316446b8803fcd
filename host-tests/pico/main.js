// node main.js IMAGE: the board in the hands of another program. Each line on the standard input is a request in JSON, each line
// on the standard output an answer; while the board runs, an event on an I²C bus is a question that the other program answers
// first. All time is the board's own: nothing here looks at a clock.
import { readSync, writeSync } from 'node:fs';
import { Board, Lockup } from './board.js';
import { PowerCut } from './flash.js';

const NEWLINE = 10;
let input = Buffer.alloc(0);

/** The next line of the standard input, parsed; null at its end. */
function receive() {
  for (;;) {
    const end = input.indexOf(NEWLINE);
    if (end >= 0) {
      const line = input.subarray(0, end);
      input = input.subarray(end + 1);
      return JSON.parse(line.toString());
    }
    const chunk = Buffer.alloc(65536);
    const length = readSync(0, chunk);
    if (length === 0) return null;
    input = Buffer.concat([input, chunk.subarray(0, length)]);
  }
}

function answer(message) {
  const bytes = Buffer.from(`${JSON.stringify(message)}\n`);
  for (let at = 0; at < bytes.length; ) at += writeSync(1, bytes, at);
}

/** What has happened since the last answer. */
let news = { uart: [], usb: [], pins: [] };
let lines = 0;
let isDead = false;

const board = new Board(process.argv[2], {
  i2c(bus, event) {
    answer({ ...event, bus, ns: board.nanos });
    return receive() ?? process.exit(0);
  },
  byte(port, byte) {
    news[port].push(byte);
    if (byte === NEWLINE) lines++;
  },
  pin(pin, level) {
    news.pins.push([pin, level, board.nanos]);
  },
});

const text = (bytes) => Buffer.from(bytes).toString('latin1');
const hex = (bytes) => Buffer.from(bytes).toString('hex');

const requests = {
  /** Runs for `ns`, or until `lines` lines were sent. */
  run({ ns, lines: enough }) {
    let ended = 'time';
    lines = 0;
    if (isDead) throw new Error('the board has no power');
    try {
      board.run(ns, () => enough !== null && lines >= enough);
      if (enough !== null && lines >= enough) ended = 'lines';
    } catch (event) {
      if (event instanceof PowerCut) ended = 'power';
      else if (event instanceof Lockup) ended = 'lockup';
      else throw event;
      isDead = true;
    }
    const { uart, usb, pins } = news;
    news = { uart: [], usb: [], pins: [] };
    return { ended, ns: board.nanos, uart: text(uart), usb: text(usb), pins };
  },
  send: ({ port, text }) => board.send(port, Buffer.from(text, 'latin1')),
  pin: ({ pin, level }) => board.drive(pin, level),
  /** What the converter finds at a channel: 0 to 3 are pins, 4 is the processor's temperature. */
  analog({ channel, counts }) {
    board.mcu.adc.channelValues[channel] = counts;
  },
  cut: ({ after, seed }) => board.flash.cut(after, seed),
  power() {
    isDead = false;
    news = { uart: [], usb: [], pins: [] };
    board.powerOn();
  },
  state: () => board.state(),
  watch: ({ address }) => board.watch(address & ~1),
  memory: ({ address, length }) => hex(Array.from({ length }, (_, i) => board.mcu.readUint8(address + i))),
  poke: ({ address, bytes }) => Buffer.from(bytes, 'hex').forEach((byte, i) => board.mcu.writeUint8(address + i, byte)),
  flash: ({ at, bytes }) => board.flash.memory.set(Buffer.from(bytes, 'hex'), at),
  jump({ pc, sp }) {
    if (pc !== null) board.mcu.core.PC = pc;
    if (sp !== null) board.mcu.core.SP = sp;
  },
};

for (let request = receive(); request; request = receive()) {
  try {
    const act = requests[request.do];
    if (!act) throw new Error(`no request ${request.do}`);
    answer({ ok: act(request) ?? null });
  } catch (error) {
    answer({ error: `${error.message}`, where: `${error.stack}` });
  }
}
