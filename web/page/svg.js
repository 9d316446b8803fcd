// Figures as SVG: for files, and for paper. Text is set as text; nothing that comes from a log is read as markup.
import { h, save } from "./dom.js";

const SPACE = "http://www.w3.org/2000/svg";
const WIDTH = 720;
const HEIGHT = 330;
const EDGE = { left: 66, right: 14, top: 44, bottom: 46 };
// The light theme: a file or a sheet of paper is white.
const COLOURS = { "--text": "#16181d", "--soft": "#555c68", "--line": "#c9ced6", "--blue": "#0062a3", "--orange": "#b34700", "--green": "#00724f", "--grey": "#6b7280", "--gap": "#d55e00", "--lit": "#56b4e9" };
export const ink = (name) => COLOURS[name] ?? "#000";

/** An SVG element with attributes and children; strings become text. */
export function s(tag, attributes = {}, ...children) {
  const node = document.createElementNS(SPACE, tag);
  for (const [name, value] of Object.entries(attributes)) if (value !== null && value !== undefined) node.setAttribute(name, String(value));
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

/** Ticks at round numbers, and how many decimals they need. */
function linear(low, high, about) {
  const rough = (high - low) / about;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((each) => each * power).find((each) => each >= rough) ?? rough;
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const all = [];
  for (let at = Math.ceil(low / step - 1e-9); at * step <= high + 1e-9 * step; at += 1) all.push([at * step, (at * step).toFixed(Math.min(12, decimals))]);
  return all;
}

/** Ticks at powers of ten; at 2 and 5 too if there are few powers. */
function decades(low, high) {
  const all = [];
  const few = Math.log10(high / low) < 2;
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power += 1) {
    for (const each of few ? [1, 2, 5] : [1]) {
      const value = each * 10 ** power;
      if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9)) all.push([value, value >= 1e-3 && value < 1e5 ? String(Number(value.toPrecision(3))) : value.toExponential(0)]);
    }
  }
  return all;
}

/** From values to a length of the axis. */
function axis(values, log, from, to) {
  const known = values.filter((value) => typeof value === "number" && Number.isFinite(value) && (!log || value > 0));
  if (!known.length) return null;
  let [low, high] = known.reduce(([least, most], value) => [Math.min(least, value), Math.max(most, value)], [Infinity, -Infinity]);
  if (low === high) [low, high] = log ? [low / 2, high * 2] : [low - 1, high + 1];
  const at = log ? Math.log10 : (value) => value;
  const margin = log ? 0 : 0.03 * (high - low);
  const [first, last] = [at(low) - margin, at(high) + margin];
  const place = (value) => from + ((at(value) - first) / (last - first)) * (to - from);
  return { place, known: (value) => typeof value === "number" && Number.isFinite(value) && (!log || value > 0), ticks: log ? decades(low, high) : linear(low - margin, high + margin, 6) };
}

/** A plot as an SVG element, of what a `Plot` was given. */
export function plotted(title, { x, series, axes, marks }) {
  const [right, bottom] = [WIDTH - EDGE.right, HEIGHT - EDGE.bottom];
  const across = axis(x, axes.logX, EDGE.left, right);
  const up = axis(series.flatMap((one) => one.values), axes.logY, bottom, EDGE.top);
  const root = s("svg", { xmlns: SPACE, viewBox: `0 0 ${WIDTH} ${HEIGHT}`, "font-family": "sans-serif", "font-size": 12, role: "img", "aria-label": title });
  root.append(s("rect", { width: WIDTH, height: HEIGHT, fill: "#fff" }), s("text", { x: EDGE.left, y: 16, fill: ink("--text"), "font-size": 13 }, title));
  if (!across || !up) return root;
  const two = (value) => value.toFixed(1);
  for (const { from, to } of marks ?? []) {
    const [left, end] = [from, to].map((value) => Math.min(right, Math.max(EDGE.left, across.place(value))));
    root.append(s("rect", { x: two(left), y: EDGE.top, width: two(Math.max(1, end - left)), height: bottom - EDGE.top, fill: ink("--gap"), "fill-opacity": 0.25 }));
  }
  for (const [value, text] of across.ticks) {
    const at = two(across.place(value));
    root.append(s("line", { x1: at, x2: at, y1: EDGE.top, y2: bottom, stroke: ink("--line") }), s("text", { x: at, y: bottom + 15, "text-anchor": "middle", fill: ink("--text") }, text));
  }
  for (const [value, text] of up.ticks) {
    const at = up.place(value);
    root.append(s("line", { x1: EDGE.left, x2: right, y1: two(at), y2: two(at), stroke: ink("--line") }), s("text", { x: EDGE.left - 6, y: two(at + 4), "text-anchor": "end", fill: ink("--text") }, text));
  }
  root.append(s("text", { x: (EDGE.left + right) / 2, y: HEIGHT - 8, "text-anchor": "middle", fill: ink("--text") }, axes.x),
    s("text", { x: 14, y: (EDGE.top + bottom) / 2, "text-anchor": "middle", fill: ink("--text"), transform: `rotate(-90 14 ${(EDGE.top + bottom) / 2})` }, axes.y));
  const places = (one) => x.map((value, i) => (across.known(value) && up.known(one.values[i]) ? [across.place(value), up.place(one.values[i])] : null));
  for (const one of series) {
    const other = one.fillTo === undefined ? null : series[one.fillTo];
    if (!other) continue;
    const [high, low] = [places(one), places(other)];
    // A gap in the series is a gap in the band.
    const runs = [[]];
    high.forEach((at, i) => {
      if (at && low[i]) runs.at(-1).push(i);
      else if (runs.at(-1).length) runs.push([]);
    });
    for (const run of runs) {
      const ring = [...run.map((i) => high[i]), ...[...run].reverse().map((i) => low[i])].map((at) => at.map(two).join(",")).join(" ");
      if (run.length) root.append(s("polygon", { points: ring, fill: ink(one.colour), "fill-opacity": 0.35 }));
    }
  }
  for (const one of series) {
    const at = places(one);
    if (one.points) {
      root.append(s("g", { fill: ink(one.colour) }, at.filter(Boolean).map(([cx, cy]) => s("circle", { cx: two(cx), cy: two(cy), r: two(one.points / 2.4) }))));
      continue;
    }
    let path = "";
    let pen = false;
    for (const place of at) {
      // Series with bins of their own have gaps of `undefined`, over which the line goes on.
      if (place) path += `${pen ? "L" : "M"}${place.map(two).join(" ")}`;
      pen = Boolean(place) || (pen && one.spans);
    }
    root.append(s("path", { d: path, fill: "none", stroke: ink(one.colour), "stroke-width": one.width ?? 1.5, "stroke-dasharray": one.dash?.join(" ") }));
  }
  let left = EDGE.left;
  // The two edges of a band are one entry.
  const named = series.filter((one) => !one.label.endsWith(" (min)")).map((one) => ({ ...one, label: one.label.replace(/ \(max\)$/, " (min to max)") }));
  for (const one of named) {
    root.append(s("line", { x1: left, x2: left + 18, y1: 30, y2: 30, stroke: ink(one.colour), "stroke-width": one.points ? 6 : 2.5, "stroke-dasharray": one.dash?.join(" ") }),
      s("text", { x: left + 23, y: 34, fill: ink("--text") }, one.label));
    left += 40 + 6.4 * one.label.length;
  }
  return root;
}

/** A button that saves what `make` draws; nothing is drawn before. */
export function saver(name, make) {
  return h("button", { type: "button", class: "small no-print", "data-svg": name, onclick: () => save(`${name}.svg`, `${new XMLSerializer().serializeToString(make())}\n`, "image/svg+xml") }, "Save as SVG");
}
