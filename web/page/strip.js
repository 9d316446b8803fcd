// The error of the corrected magnitude over the last seconds: a strip that moves on, and its rms.
import { Plot } from "./plots.js";

const LENGTH = 600;
// The eye follows numbers and dots; a strip may come after.
const DUE_MS = 200;

export class Strip {
  constructor(id) {
    this.plot = new Plot(id, "Error of the corrected magnitude, the last seconds (µT)");
    this.plot.watch();
    this.clear();
  }

  /** Begins again: what stood there was another model's. */
  clear() {
    this.at = [];
    this.values = [];
    this.plot.whole.hidden = true;
  }

  /** Takes a sample: the board's time in s, the error in µT. */
  take(at_s, value) {
    if (this.at.length && at_s < this.at.at(-1)) this.clear();
    this.at.push(at_s);
    this.values.push(value);
    if (this.at.length > LENGTH) {
      this.at.shift();
      this.values.shift();
    }
  }

  /** The rms of the error in µT and over how many seconds; nothing before there are two samples. */
  rms() {
    if (this.values.length < 2) return null;
    const squares = this.values.reduce((sum, value) => sum + value * value, 0);
    return { ut: Math.sqrt(squares / this.values.length), s: this.at.at(-1) - this.at[0], samples: this.values.length };
  }

  draw(now) {
    if (this.values.length < 2 || (this.drawn && now - this.drawn < DUE_MS)) return;
    this.drawn = now;
    if (this.plot.whole.hidden) this.plot.whole.hidden = false;
    this.plot.stream(this.at, this.values, { x: "time, s", y: "error, µT", label: "error, µT" });
  }
}
