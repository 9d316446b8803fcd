// The numbers of the moment. They change thirty times a second, so each has a place of its own that moves nothing around it.
import { h } from "./dom.js";

const CELLS = [
  ["error", "error"], ["rms", "error, rms"], ["heading", "heading if level"], ["magnitude", "magnitude"],
  ["x", "x"], ["y", "y"], ["z", "z"], ["recorded", "samples recorded"],
];

// What changes slowly by its nature is written as often as this.
const SLOW_MS = 250;

export class Readings {
  constructor(id) {
    this.texts = {};
    const cell = ([name, label]) => {
      const [title, value] = [document.createTextNode(label), document.createTextNode("–")];
      const root = h("div", { class: "now", id: `now-${name}` }, h("span", {}, title), h("strong", {}, value));
      this.texts[name] = { title, value, root };
      return root;
    };
    this.root = h("div", { class: "readings", id }, CELLS.map(cell));
  }

  set(name, text, label = null) {
    const { title, value } = this.texts[name];
    if (value.data !== text) value.data = text;
    if (label && title.data !== label) title.data = label;
  }

  /** Shows a sample `at` in µT and, of a corrected one, what is known of it `now`; the rms of the last ones; the recording. */
  show({ at, corrected, now, rms, recorded }) {
    // What only a calibration gives has no empty place before there is one.
    if (this.corrected !== corrected) {
      this.corrected = corrected;
      for (const name of ["error", "rms", "heading"]) this.texts[name].root.hidden = !corrected;
    }
    ["x", "y", "z"].forEach((axis, index) => this.set(axis, at ? `${at[index].toFixed(2)} µT` : "–", `${axis} ${corrected ? "corrected" : "measured"}`));
    this.set("magnitude", now ? `${now.norm.toFixed(2)} µT` : at ? `${Math.hypot(...at).toFixed(2)} µT` : "–");
    this.set("error", now ? `${now.residual.toFixed(3)} µT` : "–");
    this.set("heading", now ? `${now.heading.toFixed(0)}°` : "–");
    const time = performance.now();
    if (time - (this.slow ?? -SLOW_MS) < SLOW_MS && Boolean(rms) === this.known) return;
    [this.slow, this.known] = [time, Boolean(rms)];
    this.set("rms", rms ? `${rms.ut.toFixed(3)} µT` : "–", rms ? `error, rms of ${rms.s.toFixed(0)} s` : "error, rms");
    this.set("recorded", recorded ? `${recorded.samples}` : "–", recorded?.lost ? `recorded, ${recorded.lost} lost` : "samples recorded");
  }
}
