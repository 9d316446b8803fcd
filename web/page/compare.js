// Two calibrations of a log, or two logs, side by side.
import { by, fill, h, table } from "./dom.js";
import { fixed, percent, significant, ut } from "./numbers.js";
import { Plot } from "./plots.js";

const COLOURS = ["--blue", "--orange", "--green", "--grey", "--text"];

/** Shows `entries` of {name, fit, rms_ut, percent, picture}. */
export function compare(entries) {
  by("beside").hidden = entries.length < 2;
  if (entries.length < 2) return;
  const row = (name, value) => [name, ...entries.map(value)];
  const histogram = new Plot("plot-beside-histogram", "Error histogram, side by side (share of samples)");
  const spectrum = new Plot("plot-beside-spectrum", "Spectrum of the error, side by side (µT/√Hz against Hz)");
  fill(by("beside-body"),
    table("Side by side", ["", ...entries.map((one) => one.name)], [
      row("error of the corrected magnitude", (one) => ut(one.rms_ut)),
      row("in % of the field", (one) => percent(one.percent)),
      row("largest error over time", (one) => ut(one.picture.timeline ? Math.max(...one.picture.timeline.residual_ut.high.map(Math.abs), ...one.picture.timeline.residual_ut.low.map(Math.abs)) : null)),
      row("field strength, µT", (one) => fixed(one.fit.field_ut, 3)),
      ...[0, 1, 2].map((axis) => row(`offset ${"xyz"[axis]}, µT`, (one) => fixed(one.fit.offset_ut?.[axis], 3))),
      ...[0, 1, 2].map((axis) => row(`matrix ${"xyz"[axis]}`, (one) => one.fit.matrix?.[axis].map((value) => fixed(value, 5)).join("  ") ?? "–")),
      row("effects", (one) => one.fit.effects.map((effect) => `${effect.id}: ${effect.coefficients.map((value) => significant(value, 3)).join(", ")}`).join("; ") || "none"),
      row("directions seen", (one) => `${fixed(100 * (one.picture.tiles?.coverage ?? null), 0)} %`),
    ]), h("div", { class: "pair" }, histogram.whole, spectrum.whole));
  const overlay = (plot, pick, x, axes) => {
    const drawn = entries.filter((one) => pick(one));
    if (!drawn.length) return;
    // Each has its own bins: all of them together, each series where it has values.
    const at = [...new Set(drawn.flatMap((one) => x(one)))].sort((a, b) => a - b);
    const place = new Map(at.map((value, index) => [value, index]));
    plot.show(at, drawn.map((one, index) => {
      const values = new Array(at.length).fill(undefined);
      x(one).forEach((value, i) => { values[place.get(value)] = pick(one)[i]; });
      return { label: one.name, values, colour: COLOURS[index % COLOURS.length], dash: index ? [6, 2 + index] : undefined, spans: true };
    }), axes);
  };
  overlay(histogram, (one) => one.picture.histogram?.with, (one) => one.picture.histogram.at_ut, { x: "error, µT", y: "share of samples" });
  overlay(spectrum, (one) => one.picture.spectrum?.with.map((v) => (v > 0 ? v : null)), (one) => one.picture.spectrum.hz, { x: "frequency, Hz", y: "error, µT/√Hz", logX: true, logY: true });
}
