// A small figure of how to turn: the sensor's box turns from how it is held now until the side that is missing is where the field is.
import { fill, h } from "./dom.js";
import { ink, s } from "./svg.js";

const FRAME_MS = 80;
const TURN_MS = 1600;
const PAUSE_MS = 900;
const SIDE = /\b(any|(?:front|back)(?:-(?:left|right))?(?:-(?:top|bottom))?|(?:left|right)(?:-(?:top|bottom))?|top|bottom) side/g;
const SIDES = { front: [1, 0, 0], back: [-1, 0, 0], right: [0, 1, 0], left: [0, -1, 0], bottom: [0, 0, 1], top: [0, 0, -1] };
const HALF = [0.62, 0.4, 0.12];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (v) => { const length = Math.hypot(...v) || 1; return v.map((one) => one / length); };

/** The direction that the name of a side stands for, in body axes (x front, y right, z bottom). */
export function direction(name) {
  return unit(name.split("-").reduce((sum, word) => sum.map((value, i) => value + (SIDES[word]?.[i] ?? 0)), [0, 0, 0]));
}

/** The two sides that a hint names: what is missing, and where the field is now. */
export function sides(hint) {
  const [missing, now] = [...hint.matchAll(SIDE)].map((match) => match[1]).filter((name) => name !== "any");
  return missing && now ? { missing: direction(missing), now: direction(now) } : null;
}

/** Turns `v` about a unit axis. */
function turned(v, about, angle) {
  const [c, n] = [Math.cos(angle), Math.sin(angle)];
  const [side, along] = [cross(about, v), dot(about, v) * (1 - c)];
  return v.map((value, i) => value * c + side[i] * n + about[i] * along);
}


/** A view from behind and from above, from the right or from the left: the way to the viewer, and the way of a direction onto paper. */
function view(side) {
  const away = unit([-0.75, side, -0.62]);
  const across = unit(cross([0, 0, 1], away)).map((value) => -value);
  const up = cross(away, across);
  return { away, flat: (v) => [90 + 62 * dot(v, across), 80 - 62 * dot(v, up)] };
}
const VIEWS = [view(0.5), view(-0.5)];

/** How long a way is on paper. */
const long = ({ flat }, way) => way.slice(1).reduce((sum, v, i) => {
  const [a, b] = [flat(way[i]), flat(v)];
  return sum + Math.hypot(a[0] - b[0], a[1] - b[1]);
}, 0);

export class Turning {
  constructor() {
    this.drawing = s("svg", { viewBox: "0 0 180 160", "aria-hidden": "true" });
    this.words = h("figcaption", { class: "note" });
    this.root = h("figure", { class: "turning", id: "turning", hidden: true }, this.drawing, this.words);
    this.still = window.matchMedia("(prefers-reduced-motion: reduce)");
  }

  /** Shows how to bring the missing side to where the field is now; nothing if there is nothing to turn. */
  show(asked) {
    this.root.hidden = !asked;
    if (!asked) {
      clearInterval(this.timer);
      this.timer = null;
      this.key = null;
      return;
    }
    const key = JSON.stringify(asked);
    if (key === this.key) return;
    this.key = key;
    const { missing, now } = asked;
    const normal = cross(missing, now);
    const other = Math.abs(missing[2]) < 0.9 ? [0, 0, 1] : [0, 1, 0];
    this.about = unit(Math.hypot(...normal) > 1e-6 ? normal : cross(missing, other));
    this.angle = Math.acos(Math.max(-1, Math.min(1, dot(missing, now))));
    this.asked = asked;
    this.way = Array.from({ length: 25 }, (_, i) => turned(missing, this.about, (this.angle * i) / 24));
    this.view = VIEWS.reduce((best, one) => (long(one, this.way) > 1.2 * long(best, this.way) ? one : best));
    this.root.dataset.angle = ((this.angle * 180) / Math.PI).toFixed(0);
    fill(this.words, `Turn the sensor by about ${this.root.dataset.angle}°, so that the orange dot moves onto the blue ring.`);
    this.begun = performance.now();
    this.draw(this.still.matches ? 0 : undefined);
    if (!this.timer && !this.still.matches) this.timer = setInterval(() => this.draw(), FRAME_MS);
  }

  draw(share = null) {
    const { away, flat } = this.view;
    const points = (all) => all.map((v) => flat(v).map((value) => value.toFixed(1)).join(",")).join(" ");
    const spent = (performance.now() - this.begun) % (TURN_MS + PAUSE_MS);
    const part = share ?? Math.min(1, spent / TURN_MS);
    const angle = this.angle * part * part * (3 - 2 * part);
    const at = (v) => turned(v, this.about, angle);
    const faces = [];
    for (let axis = 0; axis < 3; axis += 1) {
      for (const sign of [-1, 1]) {
        const normal = [0, 0, 0];
        normal[axis] = sign;
        const [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
        const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([i, j]) => {
          const corner = [0, 0, 0];
          corner[axis] = sign * HALF[axis];
          corner[b] = i * HALF[b];
          corner[c] = j * HALF[c];
          return at(corner);
        });
        if (dot(at(normal), away) > 0) faces.push(s("polygon", { points: points(corners), class: axis === 2 && sign < 0 ? "face top" : "face" }));
      }
    }
    // The arrow on the top side points to the front.
    const top = dot(at([0, 0, -1]), away) > 0 ? s("polygon", { class: "front", points: points([[0.5, 0, -0.13], [0.15, 0.2, -0.13], [0.15, 0.07, -0.13], [-0.4, 0.07, -0.13], [-0.4, -0.07, -0.13], [0.15, -0.07, -0.13], [0.15, -0.2, -0.13]].map(at)) }) : null;
    const arc = this.way;
    const [end, before] = [flat(arc[24]), flat(arc[21])];
    const course = Math.atan2(end[1] - before[1], end[0] - before[0]);
    const head = [0, 2.6, -2.6].map((turn) => [end[0] + (turn ? 9 * Math.cos(course + turn) : 0), end[1] + (turn ? 9 * Math.sin(course + turn) : 0)].map((value) => value.toFixed(1)).join(",")).join(" ");
    const [ring, mark] = [flat(this.asked.now), flat(at(this.asked.missing))];
    const front = flat(at([0.95, 0, -0.12]));
    fill(this.drawing, s("polyline", { points: points(arc), class: "arc" }), s("polygon", { points: head, class: "head" }), faces, top,
      s("text", { x: front[0].toFixed(1), y: front[1].toFixed(1), class: "where" }, "front"),
      s("circle", { cx: ring[0].toFixed(1), cy: ring[1].toFixed(1), r: 8, class: "ring" }), s("circle", { cx: mark[0].toFixed(1), cy: mark[1].toFixed(1), r: 5, class: "mark-dot", fill: ink("--gap") }));
  }
}
