// The error with each effect added: every candidate is a switch, and switching one fits again.
import { by, fill, h } from "./dom.js";
import { chance, percent, ut } from "./numbers.js";

const MOST = 4;
const ORDER = { missing: 0, confounded: 1, "not-needed": 2, untestable: 3 };
/** What the page calls each status. */
const STATUS = { missing: "found", confounded: "confounded", "not-needed": "not needed", untestable: "not testable" };

export class Staircase {
  /** `refit` is asked for a look with a list of effects. */
  constructor(refit) {
    this.refit = refit;
    this.errors = new Map();
    this.on = [];
  }

  show(look, found) {
    by("falling").hidden = !found && look.fit.rms_ut === null;
    this.found = found;
    this.on = [...look.asked.add];
    // The search has fitted the steps up to what it found.
    const field = look.fit.field_ut;
    (found?.steps ?? []).forEach((step, index, steps) => {
      const added = steps.slice(0, index + 1).map((one) => one.added).filter(Boolean);
      if (field) this.errors.set(added.join(" "), { rms: step.rms_ut, share: (100 * step.rms_ut) / field });
    });
    if (look.figures.without_effects_ut !== null && field) this.errors.set("", { rms: look.figures.without_effects_ut, share: (100 * look.figures.without_effects_ut) / field });
    this.took(look);
    this.list();
  }

  /** Remembers the error of a look, and draws the stairs. */
  took(look) {
    if (look.fit.rms_ut !== null) this.errors.set(look.asked.add.join(" "), { rms: look.fit.rms_ut, share: look.figures.after_percent });
    this.floor = look.figures.floor_ut ?? this.floor;
    this.stairs();
  }

  stairs() {
    this.steps ??= h("div", { class: "stairs", id: "stairs" });
    const rows = [["offset and matrix", this.errors.get("")]];
    this.on.forEach((id, index) => rows.push([`+ ${id}`, this.errors.get(this.on.slice(0, index + 1).join(" "))]));
    const known = rows.filter(([, error]) => error);
    const most = Math.max(...known.map(([, error]) => error.rms), this.floor ?? 0, 1e-9);
    const bar = (rms, kind) => h("div", { class: "track" }, h("div", { class: `bar ${kind}`, style: null, "data-share": (100 * rms / most).toFixed(2) }));
    fill(this.steps, known.flatMap(([name, { rms, share }], index) => [
      h("span", {}, name), h("span", { "data-step": name }, `${ut(rms)}, ${percent(share)}`), bar(rms, index + 1 === known.length ? "last" : ""),
    ]), this.floor ? [h("span", {}, "noise floor"), h("span", {}, ut(this.floor)), bar(this.floor, "noise")] : []);
    for (const one of this.steps.querySelectorAll("[data-share]")) one.style.width = `${one.dataset.share}%`;
  }

  list() {
    const candidates = [...(this.found?.candidates ?? [])].sort((a, b) => ORDER[a.status] - ORDER[b.status]);
    const few = candidates.filter((one) => one.status === "missing" || one.status === "confounded" || this.on.includes(one.id));
    const many = candidates.filter((one) => !few.includes(one));
    const one = (row) => this.switch(row);
    const counts = Object.entries(STATUS).slice(2).map(([status, words]) => [many.filter((row) => row.status === status).length, words]).filter(([count]) => count);
    fill(by("falling-body"), this.steps,
      candidates.length ? h("p", { class: "note no-print" }, `Each switch refits the model with the selected effects, up to ${MOST}.${this.on.length ? " The effects that were found are on." : ""}`) : null,
      h("fieldset", { class: "switches" }, h("legend", {}, "Effects"), few.map(one),
        many.length ? h("details", { class: "no-print" }, h("summary", {}, `${many.length} more: ${counts.map(([count, words]) => `${count} ${words}`).join(", ")}`), h("div", { class: "switches" }, many.map(one))) : null,
        candidates.length ? null : h("p", { class: "note" }, "This log was fitted without a search for missing effects.")));
  }

  switch(row) {
    const base = ["misalignment", "axis-order"].includes(row.id);
    const box = h("input", {
      type: "checkbox", role: "switch", "data-effect": row.id, id: `switch-${row.id}`,
      disabled: row.status === "untestable" || base,
      onchange: ({ target }) => this.turned(row.id, target),
    });
    box.checked = this.on.includes(row.id);
    const held = row.holdout_rms_ut === null ? "" : ` Held-out error ${row.residual === "dip" ? `${row.holdout_rms_ut.toFixed(2)}°` : ut(row.holdout_rms_ut)}, p = ${chance(row.p_value)}.`;
    return h("div", { class: "switch" }, box,
      h("label", { for: `switch-${row.id}` }, `${row.name} (${row.id})`, h("span", { class: `tag ${row.status}` }, STATUS[row.status] ?? row.status)),
      h("span", { class: "why" }, row.why, row.why.endsWith(".") ? "" : ".", base ? " It belongs to the matrix." : held.replace("p = <", "p <")));
  }

  async turned(id, box) {
    const before = this.on;
    this.on = box.checked ? [...before, id] : before.filter((one) => one !== id);
    if (this.on.length > MOST) {
      this.on = before;
      box.checked = false;
      return;
    }
    const boxes = [...document.querySelectorAll("[data-effect]:not(:disabled)")];
    boxes.forEach((one) => { one.disabled = true; });
    const done = await this.refit(this.on);
    if (!done) {
      this.on = before;
      box.checked = before.includes(id);
    }
    boxes.forEach((one) => { one.disabled = false; });
    box.focus();
    this.stairs();
  }
}
