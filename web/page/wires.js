// Ways to a board: Web Serial, and the program that serves this page. Both give lines and take lines.

const BAUD = 115200;
const PAUSE_MS = 1000;

/** Cuts text into lines. */
function cutter(take) {
  let rest = "";
  return (text) => {
    const lines = (rest + text).split(/\r?\n/);
    rest = lines.pop().slice(-4096);
    for (const line of lines) if (line) take(line);
  };
}

/** A port that the person has chosen; it is opened again whenever it comes back. */
export class SerialWire {
  constructor(port) {
    this.port = port;
    this.name = "the serial port";
  }

  static get possible() {
    return "serial" in navigator;
  }

  static async choose() {
    return new SerialWire(await navigator.serial.requestPort());
  }

  /** `on` is told {line} and {open, why}. Ends only with [`close`]. */
  async run(on) {
    while (!this.closed) {
      try {
        await this.port.open({ baudRate: BAUD });
        on({ open: true, why: "" });
        const decoder = new TextDecoder();
        const cut = cutter((line) => on({ line }));
        this.reader = this.port.readable.getReader();
        for (;;) {
          const { value, done } = await this.reader.read();
          if (done) break;
          cut(decoder.decode(value, { stream: true }));
        }
        on({ open: false, why: "the port was closed" });
      } catch (error) {
        on({ open: false, why: error.message });
      }
      try {
        this.reader?.releaseLock();
        await this.port.close();
      } catch {
        // It is gone already.
      }
      if (!this.closed) await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
    }
  }

  async say(text) {
    const writer = this.port.writable.getWriter();
    try {
      await writer.write(new TextEncoder().encode(`${text}\n`));
    } finally {
      writer.releaseLock();
    }
  }

  async close() {
    this.closed = true;
    await this.reader?.cancel();
  }
}

/** The program's own way to the board, on this machine. */
export class ServedWire {
  constructor() {
    this.name = "the board";
  }

  run(on) {
    return new Promise((resolve) => {
      this.events = new EventSource("lines");
      this.events.addEventListener("state", ({ data }) => on(JSON.parse(data)));
      this.events.addEventListener("lines", ({ data }) => {
        for (const line of JSON.parse(data)) on({ line });
      });
      this.events.onerror = () => on({ open: false, why: "the program that serves this page does not answer" });
      this.done = resolve;
    });
  }

  async say(text) {
    const answer = await fetch("say", { method: "POST", headers: { "X-Ironout": "1" }, body: text });
    if (!answer.ok) throw new Error(await answer.text());
  }

  async close() {
    this.events?.close();
    this.done?.();
  }
}
