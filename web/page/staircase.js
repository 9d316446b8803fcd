// The staircase of falling error: every candidate is a switch, and switching one fits anew.
import { by, fill, h } from "./dom.js";
import { chance, percent, ut } from "./numbers.js";

const MOST = 4;
const ORDER = { missing: 0, confounded: 1, "not-needed": 2, untestable: 3 };

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
    ]), this.floor ? [h("span", {}, "noise alone"), h("span", {}, ut(this.floor)), bar(this.floor, "noise")] : []);
    for (const one of this.steps.querySelectorAll("[data-share]")) one.style.width = `${one.dataset.share}%`;
  }

  list() {
    const candidates = [...(this.found?.candidates ?? [])].sort((a, b) => ORDER[a.status] - ORDER[b.status]);
    const few = candidates.filter((one) => one.status === "missing" || one.status === "confounded" || this.on.includes(one.id));
    const many = candidates.filter((one) => !few.includes(one));
    const one = (row) => this.switch(row);
    fill(by("falling-body"), this.steps,
      candidates.length ? h("p", { class: "note" }, `Each switch fits offset, matrix and all that is switched on anew; ${MOST} at most.`) : null,
      h("fieldset", { class: "switches" }, h("legend", {}, "Effects"), few.map(one),
        many.length ? h("details", {}, h("summary", {}, `${many.length} more that the data do not ask for or cannot test`), h("div", { class: "switches" }, many.map(one))) : null,
        candidates.length ? null : h("p", { class: "note" }, "No search was made.")));
  }

  switch(row) {
    const base = ["misalignment", "axis-order"].includes(row.id);
    const box = h("input", {
      type: "checkbox", role: "switch", "data-effect": row.id, id: `switch-${row.id}`,
      disabled: row.status === "untestable" || base,
      onchange: ({ target }) => this.turned(row.id, target),
    });
    box.checked = this.on.includes(row.id);
    const held = row.holdout_rms_ut === null ? "" : ` On unseen time ${row.residual === "dip" ? `${row.holdout_rms_ut.toFixed(2)}°` : ut(row.holdout_rms_ut)}; chance ${chance(row.p_value)}.`;
    return h("div", { class: "switch" }, box,
      h("label", { for: `switch-${row.id}` }, `${row.name} (${row.id})`, h("span", { class: `tag ${row.status}` }, row.status)),
      h("span", { class: "why" }, row.why, row.why.endsWith(".") ? "" : ".", base ? " It belongs to the matrix." : held));
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
