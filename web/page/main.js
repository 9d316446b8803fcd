// The page, put together: what is in it is shown, what is asked goes to the worker.
import { by, fill, h, later } from "./dom.js";
import { compare } from "./compare.js";
import { Engine } from "./engine.js";
import { Figures } from "./figures.js";
import { redraw } from "./plots.js";
import { Staircase } from "./staircase.js";

const text = async (part, name) => {
  const bytes = await part(name);
  return bytes ? new TextDecoder().decode(bytes) : null;
};

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
      const look = await this.engine.ask({ do: "look", place: this.place, asked: { add, search: false, field_ut, at } });
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
