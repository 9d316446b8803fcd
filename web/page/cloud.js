// What a board has sampled, on the sphere: the dots of the last samples and the tiles that they light.
import { Sphere } from "./sphere.js";

const POINTS = 2000;
// A dot that is as near to the last one shows nothing new, µT.
const APART_UT = 0.4;
// So far, in radii, the dots may have moved before the sphere is built again.
const MOVED = 0.01;
// A picture is due as often as this. Where the processor draws what is in 3-D, each costs it a twentieth of a second.
const DUE_MS = 500;
const SPARED_MS = 2500;
const SLICES = 6;
const SECTORS = 8;
const SIDES = [["back", "", "front"], ["left", "", "right"], ["top", "", "bottom"]];

/** The name of the side a direction points through. */
function side(direction) {
  const words = direction.map((value, axis) => SIDES[axis][value > 0.4 ? 2 : value < -0.4 ? 0 : 1]).filter(Boolean);
  return words.join("-") || "any";
}

/** The direction of the middle of a tile. */
function centreOf(tile) {
  const z = ((Math.floor(tile / SECTORS) + 0.5) * 2) / SLICES - 1;
  const angle = (((tile % SECTORS) + 0.5) / SECTORS) * 2 * Math.PI;
  const level = Math.sqrt(1 - z * z);
  return [level * Math.cos(angle), level * Math.sin(angle), z];
}

/** How many of the vectors lie in each tile of equal area. */
function tiles(vectors, middle) {
  const samples = new Array(SLICES * SECTORS).fill(0);
  for (const own of vectors) {
    const v = own.map((value, axis) => value - middle[axis]);
    const length = Math.hypot(...v);
    if (!(length > 0)) continue;
    const slice = Math.min(SLICES - 1, Math.floor(((v[2] / length + 1) / 2) * SLICES));
    const turn = (Math.atan2(v[1], v[0]) / (2 * Math.PI) + 1) % 1;
    samples[slice * SECTORS + Math.min(SECTORS - 1, Math.floor(turn * SECTORS))] += 1;
  }
  const sides = samples.map((_, tile) => side(centreOf(tile)));
  return { slices: SLICES, sectors: SECTORS, samples, sides };
}

export class Cloud {
  constructor(root, id) {
    this.sphere = new Sphere(root, id, POINTS);
    this.clear();
  }

  /** Nothing of what was sampled counts any more. */
  clear() {
    this.points = [];
    this.more = false;
    this.built = null;
  }

  /** Takes a sample, µT. */
  take(v) {
    const last = this.points.at(-1);
    if (last && Math.hypot(v[0] - last[0], v[1] - last[1], v[2] - last[2]) < APART_UT) return;
    this.points.push(v);
    this.more = true;
    if (this.points.length > POINTS) this.points.shift();
  }

  /** The nearest direction that no sample has, and the present one; nothing if there is no gap. */
  gap() {
    if (this.points.length < 20) return null;
    const ends = [0, 1, 2].map((axis) => this.points.reduce(([least, most], v) => [Math.min(least, v[axis]), Math.max(most, v[axis])], [Infinity, -Infinity]));
    const middle = ends.map(([least, most]) => (least + most) / 2);
    const lit = tiles(this.points, middle);
    const at = this.points.at(-1).map((value, axis) => value - middle[axis]);
    const length = Math.hypot(...at) || 1;
    const now = at.map((value) => value / length);
    let best = null;
    lit.samples.forEach((count, tile) => {
      if (count) return;
      const centre = centreOf(tile);
      const near = centre.reduce((sum, value, axis) => sum + value * now[axis], 0);
      if (!best || near > best.near) best = { near, centre };
    });
    const names = best && [side(best.centre), side(now)];
    return best && names[0] !== names[1] ? { missing: best.centre, now, names } : null;
  }

  /** Draws what has come, where a picture is due and seen. */
  draw(now, corrected) {
    const due = this.sphere.spared ? SPARED_MS : DUE_MS;
    if (!this.more || !this.sphere.seen || (this.built && now - this.at < due)) return;
    this.at = now;
    this.more = false;
    this.show(corrected);
  }

  /** The sphere: built again where tiles were lit or it has grown, else only its dots are moved. */
  show(corrected) {
    const axes = [0, 1, 2].map((axis) => this.points.map((v) => v[axis]));
    const ends = axes.map((axis) => [Math.min(...axis), Math.max(...axis)]);
    // Before there is a calibration directions are taken about the middle of what was measured.
    const middle = corrected ? [0, 0, 0] : ends.map(([least, most]) => (least + most) / 2);
    const radius = this.points.reduce((most, v) => Math.max(most, Math.hypot(...v.map((value, axis) => value - middle[axis]))), 0) || 1;
    const lit = tiles(this.points, middle);
    const seen = lit.samples.map((count) => (count ? "1" : "0")).join("");
    const { built } = this;
    const still = built && built.seen === seen && built.corrected === corrected && Math.abs(radius / built.radius - 1) < MOVED
      && Math.hypot(...middle.map((value, axis) => value - built.middle[axis])) < MOVED * radius;
    const about = (centre) => axes.map((axis, index) => axis.map((value) => value - centre[index]));
    if (still) {
      this.sphere.move(about(built.middle));
      return;
    }
    this.built = { seen, corrected, radius, middle };
    // Of what is corrected nobody asks for more directions.
    const cloud = about(middle);
    this.sphere.show({
      field_ut: radius, cloud: { measured_ut: corrected ? [[], [], []] : cloud, corrected_ut: corrected ? cloud : [[], [], []] },
      tiles: { ...lit, coverage: seen.replaceAll("0", "").length / seen.length, gap_deg: 0, gap_side: "any", rough: true, plain: corrected },
    });
  }
}
