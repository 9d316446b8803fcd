// The sphere of directions in 3-D: samples as measured and as corrected, tiles that were seen, gaps. Body axes: x forward, y right,
// z down; on the screen right, up and towards the viewer.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, Color, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, OrbitControls, PerspectiveCamera, Points, PointsMaterial, Scene, Sprite, SpriteMaterial, WebGLRenderer,
} from "./three.min.js";
import { fill, h, later, table } from "./dom.js";
import { fixed } from "./numbers.js";

const STEPS = 5;
const TURN = Math.PI / 24;
const shown = ([x, y, z]) => [y, -z, -x];
const colour = (name) => new Color(getComputedStyle(document.documentElement).getPropertyValue(name).trim());

/** The corners of a tile, from the sphere's poles by slices of equal height. */
function patch(slices, sectors, tile, radius) {
  const slice = Math.floor(tile / sectors);
  const sector = tile % sectors;
  const at = (i, j) => {
    const z = -1 + (2 * (slice + i / STEPS)) / slices;
    const angle = (2 * Math.PI * (sector + j / STEPS)) / sectors;
    const level = Math.sqrt(Math.max(0, 1 - z * z));
    return shown([radius * level * Math.cos(angle), radius * level * Math.sin(angle), radius * z]);
  };
  const corners = [];
  for (let i = 0; i < STEPS; i += 1) {
    for (let j = 0; j < STEPS; j += 1) {
      corners.push(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return corners.flat();
}

function dots(vectors, scale, size, name) {
  const [x, y, z] = vectors;
  const places = new Float32Array(x.length * 3);
  for (let i = 0; i < x.length; i += 1) places.set(shown([x[i] * scale, y[i] * scale, z[i] * scale]), 3 * i);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(places, 3));
  return new Points(geometry, new PointsMaterial({ color: colour(name), size, sizeAttenuation: false }));
}

function label(text) {
  const canvas = h("canvas", { width: 128, height: 64 });
  const pen = canvas.getContext("2d");
  pen.font = "40px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.fillStyle = `#${colour("--text").getHexString()}`;
  pen.fillText(text, 64, 46);
  const sprite = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas), depthTest: false }));
  sprite.scale.set(0.5, 0.25, 1);
  return sprite;
}

export class Sphere {
  constructor(root, id = "sphere") {
    this.canvas = h("canvas", {
      id, tabindex: "0", role: "img",
      "aria-label": "Samples on the sphere; drag or use the arrow keys to turn, plus and minus to come nearer",
    });
    this.showing = { tiles: true, corrected: true, measured: true };
    const toggle = (key, text) => h("button", {
      type: "button", "aria-pressed": "true", "data-show": key,
      onclick: ({ target }) => {
        this.showing[key] = !this.showing[key];
        target.setAttribute("aria-pressed", this.showing[key]);
        this.build();
      },
    }, text);
    this.told = h("div");
    fill(root, h("div", { class: "ball" },
      h("div", {}, this.canvas, h("div", { class: "buttons" },
        toggle("measured", "● measured"), toggle("corrected", "● corrected"), toggle("tiles", "▦ seen and gaps"),
        h("button", { type: "button", onclick: () => this.home() }, "turn back"))),
      this.told));
    try {
      this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    } catch {
      this.canvas.replaceWith(h("p", { class: "note" }, "This browser has no WebGL, so there is no picture of the sphere; the table says the same."));
      return;
    }
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(35, 1, 0.05, 200);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enablePan = false;
    // The wheel, and a finger up and down, move the page.
    this.controls.enableZoom = false;
    this.canvas.style.touchAction = "pan-y";
    this.controls.addEventListener("change", () => this.draw());
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.size()).observe(this.canvas);
    this.home();
  }

  home() {
    this.camera.position.set(1.6, 1.5, 2.4).setLength(this.distance ?? 3.8);
    this.controls.update();
    this.draw();
  }

  key(event) {
    const turn = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] }[event.key];
    const nearer = { "+": 0.9, "=": 0.9, "-": 1.1 }[event.key];
    if (!turn && !nearer) return;
    event.preventDefault();
    const { position } = this.camera;
    const length = position.length() * (nearer ?? 1);
    const polar = Math.min(Math.PI - 0.05, Math.max(0.05, Math.acos(position.y / position.length()) + (turn?.[1] ?? 0)));
    const angle = Math.atan2(position.x, position.z) + (turn?.[0] ?? 0);
    position.set(length * Math.sin(polar) * Math.sin(angle), length * Math.cos(polar), length * Math.sin(polar) * Math.cos(angle));
    this.controls.update();
    this.draw();
  }

  size() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (this.asked || !this.renderer) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.camera.lookAt(0, 0, 0);
      this.renderer.render(this.scene, this.camera);
      const { x, y, z } = this.camera.position;
      this.canvas.dataset.view = [x, y, z].map((value) => value.toFixed(3)).join(" ");
    });
  }

  /** Shows a picture: its cloud and its tiles. */
  show(picture) {
    this.picture = picture;
    this.tell();
    this.build();
  }

  build() {
    if (!this.renderer || !this.picture) return;
    const { cloud, tiles, field_ut: field } = this.picture;
    const of = cloud.measured_ut;
    const farthest = of[0].reduce((most, _, i) => Math.max(most, Math.hypot(of[0][i], of[1][i], of[2][i])), 0);
    const scale = 1 / (field ?? (farthest || 1));
    this.scene.traverse((one) => {
      one.geometry?.dispose();
      one.material?.map?.dispose();
      one.material?.dispose();
    });
    this.scene.clear();
    const group = new Group();
    if (tiles && this.showing.tiles) {
      const [places, colours] = [[], []];
      tiles.samples.forEach((count, tile) => {
        const corners = patch(tiles.slices, tiles.sectors, tile, 0.97);
        const { r, g, b } = colour(count ? "--lit" : "--gap");
        places.push(...corners);
        for (let i = 0; i < corners.length; i += 3) colours.push(r, g, b);
      });
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
      geometry.setAttribute("color", new BufferAttribute(new Float32Array(colours), 3));
      group.add(new Mesh(geometry, new MeshBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.28, side: DoubleSide, depthWrite: false })));
    }
    if (this.showing.measured && of[0].length) group.add(dots(of, scale, 2.5, "--orange"));
    if (this.showing.corrected && cloud.corrected_ut[0]?.length) group.add(dots(cloud.corrected_ut, scale, 3, "--blue"));
    const ends = [["front", [1.25, 0, 0]], ["right", [0, 1.25, 0]], ["bottom", [0, 0, 1.25]]];
    const lines = new BufferGeometry();
    lines.setAttribute("position", new BufferAttribute(new Float32Array(ends.flatMap(([, end]) => [0, 0, 0, ...shown(end)])), 3));
    group.add(new LineSegments(lines, new LineBasicMaterial({ color: colour("--soft") })));
    for (const [text, end] of ends) {
      const sprite = label(text);
      sprite.position.set(...shown(end.map((value) => value * 1.1)));
      group.add(sprite);
    }
    this.scene.add(group);
    const distance = 3.8 * (this.showing.measured ? Math.max(1, Math.min(4, 0.75 * farthest * scale)) : 1);
    if (distance !== this.distance) {
      this.distance = distance;
      this.camera.position.setLength(distance);
      if (this.camera.position.length() === 0) this.home();
    }
    this.draw();
  }

  tell() {
    const { tiles } = this.picture;
    if (!tiles) {
      fill(this.told, h("p", { class: "note" }, "Without a calibration there is no sphere: the dots are what was measured."));
      return;
    }
    const sides = new Map();
    tiles.samples.forEach((count, tile) => {
      const side = sides.get(tiles.sides[tile]) ?? { tiles: 0, seen: 0, samples: 0 };
      side.tiles += 1;
      side.seen += count ? 1 : 0;
      side.samples += count;
      sides.set(tiles.sides[tile], side);
    });
    const empty = [...sides].filter(([, side]) => side.seen < side.tiles).map(([name]) => name);
    fill(this.told,
      h("p", {}, tiles.rough ? `${fixed(100 * tiles.coverage, 0)} % of the tiles have samples, among the last ones that are drawn.`
        : `${fixed(100 * tiles.coverage, 0)} % of all directions were seen; the largest gap is ${fixed(tiles.gap_deg, 0)}°` +
          (tiles.gap_deg > 30 ? `, on the ${tiles.gap_side} side.` : ".")),
      empty.length ? h("p", {}, `Gaps: ${empty.join(", ")}.`) : null,
      later("Tiles as a table", () => table("Tiles of equal area by the side of the board that the field came through", ["side", "seen", "tiles", "samples"],
        [...sides].map(([name, side]) => [name, side.seen, side.tiles, side.samples]))));
  }
}
