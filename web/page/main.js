// The page, put together: what is in it is shown, what is asked goes to the worker.
import { by, fill, h, later } from "./dom.js";
import { compare } from "./compare.js";
import { Engine } from "./engine.js";
import { Figures } from "./figures.js";
import { Live } from "./live.js";
import { redraw } from "./plots.js";
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
    fill(by("what"), { report: "report", live: "live", alone: "on this machine" }[this.mode]);
    const licences = await text(this.part, "licences");
    fill(by("footer"), h("p", {}, "Everything here was computed on this machine; the page sends nothing anywhere. "),
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
    fill(by("sentence"), "Drop a log of your magnetometer here");
    by("drop").hidden = false;
    const input = h("input", { type: "file", id: "file", multiple: true, onchange: ({ target }) => this.take([...target.files]) });
    const options = ["map", "rotate", "repair", "ut_per_count", "instance", "derive"].map((name) => [name, h("input", { type: "text", id: `option-${name}`, size: 28 })]);
    this.options = Object.fromEntries(options);
    this.search = h("input", { type: "checkbox", id: "search", checked: true });
    this.field = h("input", { type: "text", id: "option-field", size: 8 });
    this.compare = h("input", { type: "checkbox", id: "compare" });
    const connect = h("button", { type: "button", id: "connect", onclick: () => this.connect() }, "connect a board");
    const zone = h("div", { class: "zone", id: "zone" },
      h("p", {}, h("label", {}, "A log of any format that ironout reads, or a CAL.json to compare: drop it here, or ", input)),
      h("p", { id: "comparing", hidden: true }, h("label", {}, this.compare, " the next log stands beside the one that is shown")),
      h("p", {}, SerialWire.possible ? [connect, " with ironout's console, or one that prints Raw: lines as for MotionCal"]
        : h("span", { class: "note" }, "This browser has no Web Serial: a board can be connected in Chromium, Chrome or Edge.")));
    for (const kind of ["dragenter", "dragover", "dragleave", "drop"]) {
      document.addEventListener(kind, (event) => {
        event.preventDefault();
        zone.classList.toggle("over", kind === "dragenter" || kind === "dragover");
        if (kind === "drop") this.take([...event.dataTransfer.files]);
      });
    }
    fill(by("drop-body"), zone, h("p", { class: "error", id: "trouble", role: "alert", hidden: true }),
      h("details", { id: "reading-options" }, h("summary", {}, "How it is to be read"), h("p", { class: "note" }, "As the options of the command line; several of one are separated by semicolons."),
        options.map(([name, field]) => h("p", {}, h("label", {}, `--${name.replaceAll("_", "-")} `, field))), h("p", {}, h("label", {}, "--field, µT ", this.field)),
        h("p", {}, h("label", {}, this.search, " search for missing effects")),
        h("button", { type: "button", id: "again", onclick: () => this.again() }, "read again")));
  }

  asked(name) {
    const several = (field) => this.options[field].value.split(";").map((text) => text.trim()).filter(Boolean);
    const one = (field) => this.options[field].value.trim() || null;
    return { name, map: several("map"), rotate: several("rotate"), repair: several("repair"), derive: several("derive"), ut_per_count: one("ut_per_count"), instance: one("instance") === null ? null : Number(one("instance")) };
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

  trouble(text) {
    const at = by("trouble") ?? by("busy");
    at.hidden = !text;
    if (text && this.options) by("again").closest("details").open = true;
    fill(at, text);
  }

  /** Reads a log, fits it, searches, and shows it. */
  async read(log) {
    this.last = log;
    this.trouble("");
    by("verdict").hidden = false;
    fill(by("busy"), `Reading ${log.name} …`);
    document.body.dataset.busy = "true";
    try {
      const options = this.options ? this.asked(log.name) : { name: log.name };
      const field = this.field?.value.trim() ? Number(this.field.value) : null;
      this.said = await this.engine.ask({ do: "read", place: this.place, options, field_ut: field }, log.bytes);
      let { took } = this.engine;
      fill(by("busy"), `Studying ${this.said.rows} rows …`);
      const look = await this.engine.ask({ do: "look", place: this.place, asked: { search: this.search?.checked ?? true, field_ut: field } });
      took += this.engine.took;
      this.unpacked = Promise.resolve();
      this.found = look.diagnosis;
      this.beside = [];
      this.stairs.errors.clear();
      this.show(look);
      this.stairs.show(look, this.found);
      this.parts();
      if (this.options) by("comparing").hidden = false;
      document.body.dataset.log = log.name;
      document.body.dataset.took = took;
      fill(by("busy"), "");
    } catch (error) {
      fill(by("busy"), "");
      this.trouble(error.message);
    } finally {
      delete document.body.dataset.busy;
    }
  }

  /** The log under a calibration file, beside its own fit. */
  besides(name, cal) {
    return this.stand(() => this.engine.ask({ do: "under", place: this.place, cal, name }));
  }

  /** Another log under its own fit, beside this one. */
  logBeside({ name, bytes }) {
    const field_ut = this.look.asked.field_ut ?? null;
    return this.stand(async () => {
      await this.engine.ask({ do: "read", place: OTHER, options: this.asked(name), field_ut }, bytes);
      const { fit, figures, picture } = await this.engine.ask({ do: "look", place: OTHER, asked: { search: false, field_ut } });
      return { name, fit, picture, rms_ut: fit.rms_ut, percent: figures.after_percent };
    });
  }

  /** Puts what `make` gives beside what is shown. */
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
      if (!bytes) throw new Error("this page has no log to fit anew");
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
    fill(by("busy"), "Fitting anew …");
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
  // Paper is white.
  let before = null;
  window.addEventListener("beforeprint", () => {
    before = root.dataset.theme;
    set(false);
  });
  window.addEventListener("afterprint", () => set(before === "dark"));
}

let page = null;

export async function start(given) {
  page = new Page(given);
  await page.begin();
}
