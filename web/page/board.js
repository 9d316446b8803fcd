// The other end of a board's console (docs/console.md): what is asked, what is answered, and the streams in between.

const WAIT_MS = 10000;
const STREAMS = ["R,", "C,", "L,", "H,", "Raw:"];

/** The values `key=value` of a text. */
export function values(text) {
  return Object.fromEntries([...text.matchAll(/([a-z_]+)=(\S+)/g)].map(([, key, value]) => [key, value]));
}

export class Board {
  /** `on` is told {stream}, {foreign} and {said} (a line of the transcript). */
  constructor(wire, on) {
    Object.assign(this, { wire, on, queue: Promise.resolve(), waiting: null });
  }

  /** A line of the board. */
  hear(line) {
    if (STREAMS.some((mark) => line.startsWith(mark))) {
      this.on({ stream: line });
      return;
    }
    if (!this.waiting) {
      if (!/^(\+ |ok\b|err\b)/.test(line)) this.on({ foreign: line });
      return;
    }
    if (line.startsWith("+ ")) {
      this.waiting.info.push(line.slice(2));
      return;
    }
    const last = /^(ok|err)(?: (.*))?$/.exec(line);
    if (!last) {
      this.on({ foreign: line });
      return;
    }
    const { info, resolve, timer } = this.waiting;
    clearTimeout(timer);
    this.waiting = null;
    const text = last[2] ?? "";
    resolve({ ok: last[1] === "ok", text, info, closing: line, all: { ...values(info.join(" ")), ...values(text) } });
  }

  /** The wire is gone: what was asked is not answered any more. */
  gone(why) {
    if (!this.waiting) return;
    const { reject, timer } = this.waiting;
    clearTimeout(timer);
    this.waiting = null;
    reject(new Error(why));
  }

  /** Asks one line; the reply, or an error where none comes. Questions wait for each other. */
  ask(line, { quiet = false, wait = WAIT_MS } = {}) {
    const asked = this.queue.then(() => new Promise((resolve, reject) => {
      const timer = setTimeout(() => {
        this.waiting = null;
        reject(new Error(`nothing has answered \`${line.trim()}\` for ${wait / 1000} s`));
      }, wait);
      this.waiting = { info: [], resolve, reject, timer };
      this.wire.say(line).catch((error) => {
        clearTimeout(timer);
        this.waiting = null;
        reject(error);
      });
    }));
    this.queue = asked.catch(() => {});
    return asked.then((reply) => {
      if (!quiet) this.on({ said: [`> ${line}`, ...reply.info.map((text) => `+ ${text}`), reply.closing] });
      return reply;
    });
  }
}
