// The sphere of directions in 3-D: samples as measured and as corrected, tiles that were seen, gaps. Body axes: x forward, y right,
// z down; on the screen right, up and towards the viewer.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, Color, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, OrbitControls, PerspectiveCamera, Points, PointsMaterial, Scene, Sprite, SpriteMaterial, WebGLRenderer,
} from "./three.min.js";
import { fill, h, later, table } from "./dom.js";
import { fixed } from "./numbers.js";
import { ink, s, saver } from "./svg.js";

const STEPS = 5;
const TURN = Math.PI / 24;
const ENDS = [["front", [1.25, 0, 0]], ["right", [0, 1.25, 0]], ["bottom", [0, 0, 1.25]]];
const shown = ([x, y, z]) => [y, -z, -x];
const colour = (name) => new Color(getComputedStyle(document.documentElement).getPropertyValue(name).trim());

/** Places in a tile, by steps along its two sides. */
function within(slices, sectors, tile, radius) {
  const slice = Math.floor(tile / sectors);
  const sector = tile % sectors;
  return (i, j) => {
    const z = -1 + (2 * (slice + i / STEPS)) / slices;
    const angle = (2 * Math.PI * (sector + j / STEPS)) / sectors;
    const level = Math.sqrt(Math.max(0, 1 - z * z));
    return shown([radius * level * Math.cos(angle), radius * level * Math.sin(angle), radius * z]);
  };
}

/** The corners of a tile, from the sphere's poles by slices of equal height. */
function patch(slices, sectors, tile, radius) {
  const at = within(slices, sectors, tile, radius);
  const corners = [];
  for (let i = 0; i < STEPS; i += 1) {
    for (let j = 0; j < STEPS; j += 1) {
      corners.push(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return corners.flat();
}

/** The outline of a tile, as pairs of corners. */
function outline(slices, sectors, tile, radius) {
  const at = within(slices, sectors, tile, radius);
  const pairs = [];
  for (let i = 0; i < STEPS; i += 1) pairs.push(at(0, i), at(0, i + 1), at(i, 0), at(i + 1, 0));
  return pairs.flat();
}

/** Puts dots where the vectors are, with room for `most` of them, so that more cost no new buffer. */
function place(points, [x, y, z], scale, most = x.length) {
  let attribute = points.geometry.getAttribute("position");
  if (!attribute || attribute.count < most) {
    points.geometry.dispose();
    points.geometry = new BufferGeometry();
    attribute = new BufferAttribute(new Float32Array(3 * most), 3);
    points.geometry.setAttribute("position", attribute);
  }
  const count = Math.min(x.length, attribute.count);
  for (let i = 0; i < count; i += 1) attribute.array.set(shown([x[i] * scale, y[i] * scale, z[i] * scale]), 3 * i);
  attribute.needsUpdate = true;
  points.geometry.setDrawRange(0, count);
}

/** A geometry of these corners, each in its colour where there are colours. */
function corners(places, colours = null) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
  if (colours) geometry.setAttribute("color", new BufferAttribute(new Float32Array(colours), 3));
  return geometry;
}

function label(text) {
  const canvas = h("canvas", { width: 256, height: 64 });
  const pen = canvas.getContext("2d");
  pen.font = "40px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.fillStyle = `#${colour("--text").getHexString()}`;
  pen.fillText(text, 128, 46);
  const sprite = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas), depthTest: false }));
  sprite.scale.set(0.8, 0.2, 1);
  return sprite;
}

/** Whether the processor itself draws what is in 3-D: then it is spared. */
function software() {
  const context = document.createElement("canvas").getContext("webgl");
  const names = context?.getExtension("WEBGL_debug_renderer_info");
  const who = names ? String(context.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(who);
}

export class Sphere {
  /** `most` dots are made room for where they grow, and then it is not kept for paper. */
  constructor(root, id = "sphere", most = null) {
    this.most = most;
    this.canvas = h("canvas", {
      id, tabindex: "0", role: "img",
      "aria-label": "Samples by direction in 3-D. Drag or use the arrow keys to turn, plus and minus to zoom",
    });
    this.showing = { tiles: true, corrected: true, measured: true };
    const toggle = (key, mark, text) => h("button", {
      type: "button", "aria-pressed": "true", "data-show": key,
      onclick: ({ currentTarget }) => {
        this.showing[key] = !this.showing[key];
        currentTarget.setAttribute("aria-pressed", this.showing[key]);
        this.build();
      },
    }, h("span", { class: `mark ${key}`, "aria-hidden": "true" }, mark), ` ${text}`);
    this.told = h("div");
    this.seen = true;
    // A picture of many comes after what is small and changes all the time.
    this.spared = Boolean(most) && software();
    fill(root, h("div", { class: "ball" },
      h("div", {}, this.canvas, h("div", { class: "buttons" },
        toggle("measured", "●", "measured"), toggle("corrected", "●", "corrected"), toggle("tiles", "▦", "directions: seen, gaps"),
        h("button", { type: "button", onclick: () => this.home() }, "first view"), most ? null : saver("directions", () => this.drawn())), this.paper = h("div", { class: "for-print" })),
      this.told));
    try {
      this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: !this.spared, alpha: true, preserveDrawingBuffer: !most });
    } catch {
      this.canvas.replaceWith(h("p", { class: "note" }, "This browser has no WebGL, so there is no picture; the table has the same numbers."));
      return;
    }
    this.scene = new Scene();
    this.furnish();
    this.camera = new PerspectiveCamera(35, 1, 0.05, 200);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enablePan = false;
    // The wheel, and a finger up and down, move the page.
    this.controls.enableZoom = false;
    this.canvas.style.touchAction = "pan-y";
    this.controls.addEventListener("change", () => this.draw());
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.size()).observe(this.canvas);
    // What nobody sees is not drawn.
    new IntersectionObserver((all) => {
      const before = this.seen;
      this.seen = all.at(-1).isIntersecting;
      if (this.seen && !before) this.draw();
    }).observe(this.canvas);
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
    if (this.asked || !this.renderer || (this.most && !this.seen)) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.camera.lookAt(0, 0, 0);
      this.renderer.render(this.scene, this.camera);
      const { x, y, z } = this.camera.position;
      this.canvas.dataset.view = [x, y, z].map((value) => value.toFixed(3)).join(" ");
    });
  }

  /** For paper the present view is drawn as SVG; afterwards that is taken away. */
  onPaper(printing) {
    if (this.renderer && this.picture) fill(this.paper, printing ? this.drawn() : null);
  }

  /** The present view as an SVG element: tiles, dots, and the names of the axes. */
  drawn() {
    const [width, height] = [640, 460];
    this.camera.lookAt(0, 0, 0);
    this.camera.updateMatrixWorld();
    const [view, lens] = [this.camera.matrixWorldInverse.elements, this.camera.projectionMatrix.elements];
    const times = (m, [x, y, z]) => [0, 1, 2, 3].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
    const aspect = this.camera.aspect;
    const at = (v) => {
      const [x, y, , w] = times(lens, times(view, v));
      return [width / 2 + ((x / w) * aspect * height) / 2, height / 2 - ((y / w) * height) / 2].map((value) => value.toFixed(1));
    };
    const root = s("svg", { xmlns: "http://www.w3.org/2000/svg", viewBox: `0 0 ${width} ${height}`, "font-family": "sans-serif", "font-size": 13, role: "img", "aria-label": "Samples by direction" });
    root.append(s("rect", { width, height, fill: "#fff" }));
    const { cloud, tiles } = this.picture;
    if (tiles && this.showing.tiles) {
      tiles.samples.forEach((count, tile) => {
        const place = within(tiles.slices, tiles.sectors, tile, 0.97);
        const ring = [];
        for (let i = 0; i < STEPS; i += 1) ring.push(place(i, 0));
        for (let j = 0; j < STEPS; j += 1) ring.push(place(STEPS, j));
        for (let i = STEPS; i > 0; i -= 1) ring.push(place(i, STEPS));
        for (let j = STEPS; j > 0; j -= 1) ring.push(place(0, j));
        root.append(s("polygon", { points: ring.map((one) => at(one).join(",")).join(" "), fill: ink(count ? "--lit" : "--gap"), "fill-opacity": 0.22, stroke: ink("--soft"), "stroke-opacity": 0.35 }));
      });
    }
    for (const [key, name] of [["measured", "--orange"], ["corrected", "--blue"]]) {
      const [x, y, z] = cloud[`${key}_ut`];
      if (!this.showing[key] || !x?.length) continue;
      root.append(s("g", { fill: ink(name) }, x.map((_, i) => {
        const [cx, cy] = at(shown([x[i] * this.scale, y[i] * this.scale, z[i] * this.scale]));
        return s("circle", { cx, cy, r: 1.6 });
      })));
    }
    for (const [name, end] of ENDS) {
      const [[x1, y1], [x2, y2]] = [at([0, 0, 0]), at(shown(end))];
      root.append(s("line", { x1, y1, x2, y2, stroke: ink("--soft") }), s("text", { x: x2, y: y2, fill: ink("--text") }, name));
    }
    return root;
  }

  /** Shows a picture: its cloud and its tiles. */
  show(picture) {
    this.picture = picture;
    this.tell();
    this.build();
  }

  /** What the scene is made of. It stays, whatever is shown: a material that is made again is compiled again. */
  furnish() {
    const line = (more) => new LineSegments(new BufferGeometry(), new LineBasicMaterial(more));
    const cloud = (size) => {
      const points = new Points(new BufferGeometry(), new PointsMaterial({ size, sizeAttenuation: false }));
      // What is behind the camera is none of its business: the dots move on.
      points.frustumCulled = false;
      return points;
    };
    this.things = {
      tiles: new Mesh(new BufferGeometry(), new MeshBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.28, side: DoubleSide, depthWrite: false })),
      grid: line({ transparent: true, opacity: 0.3 }), axes: line(), measured: cloud(4), corrected: cloud(4), labels: new Group(),
    };
    // There is nothing to lay or to place yet.
    for (const name of ["tiles", "grid", "measured", "corrected"]) this.things[name].visible = false;
    this.things.axes.geometry = corners(ENDS.flatMap(([, end]) => [0, 0, 0, ...shown(end)]));
    this.scene.add(...Object.values(this.things));
  }

  /** Gives everything the colours of the theme. */
  paint() {
    const { grid, axes, measured, corrected, labels } = this.things;
    for (const [thing, name] of [[grid, "--soft"], [axes, "--soft"], [measured, "--orange"], [corrected, "--blue"]]) thing.material.color.copy(colour(name));
    const text = colour("--text").getHexString();
    if (this.written === text) return;
    this.written = text;
    for (const one of labels.children) {
      one.material.map.dispose();
      one.material.dispose();
    }
    labels.clear();
    for (const [name, end] of ENDS) {
      const sprite = label(name);
      sprite.position.set(...shown(end.map((value) => value * 1.1)));
      labels.add(sprite);
    }
  }

  /** Draws what is to be shown with what is switched on, in the colours of the theme. */
  build() {
    if (!this.renderer || !this.picture) return;
    const { cloud, tiles, field_ut: field } = this.picture;
    const of = cloud.measured_ut;
    const farthest = of[0].reduce((most, _, i) => Math.max(most, Math.hypot(of[0][i], of[1][i], of[2][i])), 0);
    this.scale = 1 / (field ?? (farthest || 1));
    this.paint();
    this.tile(tiles);
    this.moving = null;
    for (const key of ["measured", "corrected"]) {
      const vectors = cloud[`${key}_ut`];
      const points = this.things[key];
      points.visible = this.showing[key] && vectors[0]?.length > 0;
      if (!points.visible) continue;
      place(points, vectors, this.scale, this.most ?? vectors[0].length);
      this.moving = points;
    }
    const distance = 3.8 * (this.showing.measured ? Math.max(1, Math.min(4, 0.75 * farthest * this.scale)) : 1);
    if (distance !== this.distance) {
      this.distance = distance;
      this.camera.position.setLength(distance);
      if (this.camera.position.length() === 0) this.home();
    }
    this.draw();
  }

  /** Lays the tiles: those that were seen, and the gaps. */
  tile(tiles) {
    const { tiles: mesh, grid } = this.things;
    mesh.visible = grid.visible = Boolean(tiles) && this.showing.tiles;
    if (!mesh.visible) return;
    const [places, colours, edges] = [[], [], []];
    const [lit, gap] = [colour("--lit"), colour(tiles.plain ? "--line" : "--gap")];
    tiles.samples.forEach((count, tile) => {
      const own = patch(tiles.slices, tiles.sectors, tile, 0.97);
      const { r, g, b } = count ? lit : gap;
      places.push(...own);
      edges.push(...outline(tiles.slices, tiles.sectors, tile, 0.972));
      for (let i = 0; i < own.length; i += 3) colours.push(r, g, b);
    });
    mesh.geometry.dispose();
    mesh.geometry = corners(places, colours);
    grid.geometry.dispose();
    grid.geometry = corners(edges);
  }

  /** The same picture with other dots. */
  move(vectors) {
    if (!this.moving) return;
    place(this.moving, vectors, this.scale);
    this.draw();
  }

  tell() {
    const { tiles } = this.picture;
    this.words ??= { coverage: h("p"), gaps: h("p"), table: later("Numbers as a table", () => this.table(), true) };
    const { coverage, gaps, table: rows } = this.words;
    if (!tiles) {
      fill(this.told, h("p", { class: "note" }, "Without a calibration the readings do not lie on a sphere: the dots are the measured values."));
      return;
    }
    // A table that was opened stays open while a board is turned.
    if (!rows.isConnected) fill(this.told, coverage, gaps, rows);
    else if (rows.open) fill(rows.lastChild, this.table());
    fill(coverage, tiles.rough ? `${fixed(100 * tiles.coverage, 0)} % of directions covered (in the samples shown).`
      : `${fixed(100 * tiles.coverage, 0)} % of all directions were seen; the largest gap is ${fixed(tiles.gap_deg, 0)}°` +
        (tiles.gap_deg > 30 ? `, on the ${tiles.gap_side} side of the sensor.` : "."));
    const empty = tiles.plain ? [] : [...this.sides()].filter(([, side]) => side.seen < side.tiles).map(([name]) => name);
    fill(gaps, empty.length ? `Sides with gaps: ${empty.join(", ")}.` : null);
  }

  /** Tiles and samples by the side of the board. */
  sides() {
    const { tiles } = this.picture;
    const sides = new Map();
    tiles.samples.forEach((count, tile) => {
      const side = sides.get(tiles.sides[tile]) ?? { tiles: 0, seen: 0, samples: 0 };
      side.tiles += 1;
      side.seen += count ? 1 : 0;
      side.samples += count;
      sides.set(tiles.sides[tile], side);
    });
    return sides;
  }

  table() {
    return table("Directions in tiles of equal area, by the side of the sensor that the field came through", ["side", "tiles seen", "tiles", "samples"],
      [...this.sides()].map(([name, side]) => [name, side.seen, side.tiles, side.samples]));
  }
}
