// The page, put together: what is in it is shown, what is asked goes to the worker.
import { by, fill, h, later } from "./dom.js";
import { Reading } from "./asking.js";
import { compare } from "./compare.js";
import { Engine } from "./engine.js";
import { Figures } from "./figures.js";
import { Live } from "./live.js";
import { onPaper, redraw } from "./plots.js";
import { Staircase } from "./staircase.js";
import { ServedWire, SerialWire } from "./wires.js";

const text = async (part, name) => {
  const bytes = await part(name);
  return bytes ? new TextDecoder().decode(bytes) : null;
};

/** Where the module holds a log that is only compared. */
const OTHER = 1;

class Page {
  constructor({ mode, worker, part }) {
    Object.assign(this, { mode, part });
    this.engine = new Engine(worker, part("module"));
    this.figures = new Figures(this.engine);
    this.stairs = new Staircase((add) => this.refit(add));
    this.place = 0;
  }

  async begin() {
    theme();
    fill(by("what"), { report: "report", live: "live", alone: "magnetometer calibration" }[this.mode]);
    const licences = await text(this.part, "licences");
    fill(by("footer"), h("p", {}, "Everything runs in your browser; no data is uploaded. "),
      later("Licences", () => h("pre", { tabindex: "0" }, licences)));
    const report = await text(this.part, "report");
    if (report) this.open(JSON.parse(report));
    if (this.mode === "alone") this.alone();
    if (this.mode === "live") this.live(new ServedWire());
    document.body.dataset.ready = "true";
  }

  /** Shows a report: {log, look, beside}. */
  open(report) {
    document.title = `${report.log.name} · ironout`;
    this.said = report.log;
    this.found = report.look.diagnosis;
    this.beside = report.beside ?? [];
    this.show(report.look);
    this.stairs.show(report.look, this.found);
    this.parts();
    // The log is unpacked when there is time, or at the first switch.
    this.unpacked = null;
    const start = () => this.unpack().catch(() => {});
    if (window.requestIdleCallback) requestIdleCallback(start, { timeout: 3000 });
    else setTimeout(start, 500);
  }

  /** The page by itself: logs are dropped, boards are connected. */
  alone() {
    fill(by("sentence"), "Drop a magnetometer log here");
    fill(by("advice"), "ironout calibrates the sensor, and looks for the cause of any error that remains.");
    by("drop").hidden = false;
    const input = h("input", { type: "file", id: "file", multiple: true, onchange: ({ target }) => this.take([...target.files]) });
    this.reading = new Reading(() => this.again());
    this.compare = h("input", { type: "checkbox", id: "compare" });
    const connect = h("button", { type: "button", id: "connect", onclick: () => this.connect() }, "connect a board");
    const example = h("button", { type: "button", id: "example", onclick: () => this.example() }, "try an example log");
    const zone = h("div", { class: "zone", id: "zone" },
      h("p", {}, h("label", {}, "Drop a log (or a CAL.json to compare) here, or ", input)),
      h("p", { id: "comparing", hidden: true }, h("label", {}, this.compare, " compare the next log with this one")),
      h("p", { class: "buttons" }, example, SerialWire.possible ? connect : null),
      h("p", { class: "note" }, SerialWire.possible ? "A board needs ironout's firmware, or a sketch that prints Raw: lines as for MotionCal."
        : "To connect a board, open this page in Chromium, Chrome or Edge: this browser has no Web Serial."));
    for (const kind of ["dragenter", "dragover", "dragleave", "drop"]) {
      document.addEventListener(kind, (event) => {
        event.preventDefault();
        zone.classList.toggle("over", kind === "dragenter" || kind === "dragover");
        if (kind === "drop") this.take([...event.dataTransfer.files]);
      });
    }
    fill(by("drop-body"), h("div", { id: "asking" }), h("div", { class: "error", id: "trouble", role: "alert", hidden: true }), zone, this.reading.root);
  }

  /** Reads the log that came with the page. */
  async example() {
    const bytes = await this.part("example");
    if (bytes) await this.read({ name: "example.csv", bytes });
  }

  async take(files) {
    for (const file of files) {
      const bytes = new Uint8Array(await file.arrayBuffer());
      if (file.name.endsWith(".json") && this.look) await this.besides(file.name, new TextDecoder().decode(bytes));
      else if (this.look && this.compare.checked) await this.logBeside({ name: file.name, bytes });
      else await this.read({ name: file.name, bytes });
    }
  }

  again() {
    if (this.last) this.read(this.last);
  }

  /** Says what went wrong, with the question if the reader has one. */
  trouble(text, question = null) {
    const at = by("trouble") ?? by("busy");
    at.hidden = !text;
    at.classList.toggle("error", !question);
    fill(at, question ? h("details", {}, h("summary", {}, "The message of the command line"), h("pre", { tabindex: "0" }, text)) : text);
    if (this.reading) fill(by("asking"), question ? this.reading.form(question, () => this.again()) : null);
  }

  /** Nothing of the last log stands under the name of another one. */
  clear(name, asks = false) {
    this.look = null;
    this.beside = [];
    delete document.body.dataset.log;
    for (const part of document.querySelectorAll("main section")) if (!["verdict", "drop", "live"].includes(part.id)) part.hidden = true;
    for (const id of ["advice", "figures", "parts"]) fill(by(id));
    if (this.reading) by("comparing").hidden = true;
    fill(by("log-name"), h("strong", {}, name));
    fill(by("sentence"), h("span", { class: "badge", "data-verdict": asks ? "FOUND" : "REFUSED" }, asks ? "QUESTION" : "NOT READ"),
      asks ? " One answer is needed to read this log." : " This log could not be read.");
    document.title = `${name} · ironout`;
  }

  /** Reads a log, fits it, searches, and shows it. */
  async read(log) {
    if (this.last?.name !== log.name) {
      this.reading?.forget();
      this.figures.forget();
    }
    this.last = log;
    this.trouble("");
    by("verdict").hidden = false;
    fill(by("busy"), `Reading ${log.name} …`);
    document.body.dataset.busy = "true";
    try {
      const options = this.reading?.asked(log.name) ?? { name: log.name };
      const field = this.reading?.fieldUt ?? null;
      this.said = await this.engine.ask({ do: "read", place: this.place, options, field_ut: field }, log.bytes);
      let { took } = this.engine;
      fill(by("busy"), `Studying ${this.said.rows} rows …`);
      const look = await this.engine.ask({ do: "look", place: this.place, asked: { search: this.reading?.search.checked ?? true, field_ut: field } });
      took += this.engine.took;
      this.unpacked = Promise.resolve();
      this.found = look.diagnosis;
      this.beside = [];
      this.stairs.errors.clear();
      this.show(look);
      this.stairs.show(look, this.found);
      this.parts();
      if (this.reading) {
        by("comparing").hidden = false;
        by("zone").classList.add("compact");
        this.reading.took(this.said);
      }
      document.title = `${log.name} · ironout`;
      document.body.dataset.log = log.name;
      document.body.dataset.took = took;
      fill(by("busy"), "");
    } catch (error) {
      fill(by("busy"), "");
      this.clear(log.name, Boolean(error.question));
      this.trouble(error.message, error.question);
    } finally {
      delete document.body.dataset.busy;
    }
  }

  /** The log under a calibration file, next to its own fit. */
  besides(name, cal) {
    return this.stand(() => this.engine.ask({ do: "under", place: this.place, cal, name }));
  }

  /** Another log under its own fit, next to this one. */
  logBeside({ name, bytes }) {
    const field_ut = this.look.asked.field_ut ?? null;
    return this.stand(async () => {
      await this.engine.ask({ do: "read", place: OTHER, options: this.reading?.asked(name) ?? { name }, field_ut }, bytes);
      const { fit, figures, picture } = await this.engine.ask({ do: "look", place: OTHER, asked: { search: false, field_ut } });
      return { name, fit, picture, rms_ut: fit.rms_ut, percent: figures.after_percent };
    });
  }

  /** Puts what `make` gives next to what is shown. */
  async stand(make) {
    this.trouble("");
    document.body.dataset.busy = "true";
    try {
      this.beside.push(await make());
      this.show(this.look);
      this.parts();
    } catch (error) {
      this.trouble(error.message);
    } finally {
      delete document.body.dataset.busy;
    }
  }

  async connect() {
    try {
      this.live(await SerialWire.choose());
    } catch (error) {
      this.trouble(error.message);
    }
  }

  live(wire) {
    if (this.mode === "live") {
      // There is a verdict once a recording is looked at.
      by("verdict").hidden = true;
      document.querySelector(".skip").href = "#live";
      fill(document.querySelector(".skip"), "to the board");
    }
    this.board ??= new Live(({ name, text: log }) => this.read({ name, bytes: new TextEncoder().encode(log) }));
    this.board.follow(wire).catch((error) => this.trouble(error.message));
  }

  unpack() {
    this.unpacked ??= this.part("log").then((bytes) => {
      if (!bytes) throw new Error("this page has no log to fit again");
      return this.engine.ask({ do: "unpack", place: this.place }, bytes);
    });
    return this.unpacked;
  }

  show(look) {
    this.look = look;
    this.figures.place = this.place;
    this.figures.show(look, this.said, this.found);
    const own = look.fit.rms_ut === null ? [] : [{ name: look.asked.add.length ? `this log with ${look.asked.add.join(", ")}` : "this log, fitted", fit: look.fit, rms_ut: look.fit.rms_ut, percent: look.figures.after_percent, picture: look.picture }];
    compare([...own, ...this.beside]);
  }

  /** A look with these effects; whether there is one. */
  async refit(add) {
    fill(by("busy"), "Fitting …");
    document.body.dataset.busy = "true";
    try {
      await this.unpack();
      const { field_ut, at } = this.look.asked;
      const look = await this.engine.ask({ do: "look", place: this.place, asked: { add, search: false, field_ut, at, floor_ut: this.found?.residual_floor_ut ?? null } });
      this.show(look);
      this.stairs.took(look);
      fill(by("busy"), "");
      return true;
    } catch (error) {
      fill(by("busy"), error.message);
      return false;
    } finally {
      delete document.body.dataset.busy;
    }
  }

  /** Links to the parts that are shown. */
  parts() {
    fill(by("parts"), [...document.querySelectorAll("main section:not([hidden]) h2")].map((head) => h("a", { href: `#${head.closest("section").id}` }, head.textContent)));
  }
}

function theme() {
  const root = document.documentElement;
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const set = (on) => {
    root.dataset.theme = on ? "dark" : "light";
    by("theme").setAttribute("aria-pressed", on);
    redraw();
    page?.figures.ball?.build();
    page?.board?.cloud.sphere.build();
  };
  set(dark.matches);
  dark.addEventListener("change", () => set(dark.matches));
  by("theme").addEventListener("click", () => set(root.dataset.theme !== "dark"));
  // Paper is white, and its figures are drawn for it.
  let before = null;
  window.addEventListener("beforeprint", () => {
    before = root.dataset.theme;
    set(false);
    onPaper(true);
    page?.figures.ball?.onPaper(true);
  });
  window.addEventListener("afterprint", () => {
    onPaper(false);
    page?.figures.ball?.onPaper(false);
    set(before === "dark");
  });
}

let page = null;

export async function start(given) {
  page = new Page(given);
  await page.begin();
}
