// How a log is to be read: fields for what the reader cannot know, and the question that it has asked.
import { fill, h } from "./dom.js";

const AXES = ["x", "y", "z"];
const UNITS = [["", "detect"], ["uT", "µT"], ["nT", "nT"], ["mG", "mG (milligauss)"], ["G", "G (gauss)"], ["T", "T (tesla)"], ["counts", "counts of the chip"]];
const TIMES = [["", "detect"], ["s", "s"], ["ms", "ms"], ["us", "µs"], ["ns", "ns"]];
const RAW = ["map", "rotate", "repair", "ut_per_count", "instance", "derive"];

/** A header as `--map` takes it. */
const quoted = (header) => (/[,"]/.test(header) ? `"${header.replaceAll('"', '""')}"` : header);

const choose = (id, options) => h("select", { id }, options.map(([value, text]) => h("option", { value }, text)));
const text = (id, size = 12, more = {}) => h("input", { type: "text", id, size, ...more });
const row = (words, ...fields) => h("p", {}, h("label", {}, h("span", {}, words), fields));

/** Columns x, y, z and their unit as a `--map`; nothing if they are not all named. */
function mapped(columns, unit) {
  if (columns.some((column) => !column)) return [];
  const counts = unit === "counts";
  return [columns.map((column, i) => `m${AXES[i]}_${counts ? "counts" : "ut"}=${quoted(column)}${unit && !counts ? `[${unit}]` : ""}`).join(",")];
}

/** The fields of "How the log is read". */
export class Reading {
  /** `again` reads the log once more. */
  constructor(again) {
    this.axes = AXES.map((axis) => choose(`column-${axis}`, [["", "detect"]]));
    this.unit = choose("unit", UNITS);
    this.time = choose("column-time", [["", "detect"]]);
    this.timeUnit = choose("unit-time", TIMES);
    this.scale = text("counts-scale", 8, { inputmode: "decimal", placeholder: "for example 0.15" });
    this.field = text("option-field", 8, { inputmode: "decimal", placeholder: "µT" });
    this.search = h("input", { type: "checkbox", id: "search", checked: true });
    this.raw = Object.fromEntries(RAW.map((name) => [name, text(`option-${name}`, 28)]));
    this.answers = [];
    this.root = h("details", { id: "reading-options" }, h("summary", {}, "How the log is read"),
      h("div", { class: "form" },
        this.axes.map((select, i) => row(`magnetometer ${AXES[i]}`, select)), row("unit of the magnetometer", this.unit), row("scale, µT per count", this.scale),
        row("column of time", this.time), row("unit of time", this.timeUnit), row("true field strength, µT", this.field)),
      h("p", {}, h("label", {}, this.search, " search for missing effects")),
      h("details", { id: "raw-options" }, h("summary", {}, "Options as on the command line"), h("p", { class: "note" }, "Separate several values of one option by semicolons."),
        RAW.map((name) => row(`--${name.replaceAll("_", "-")}`, this.raw[name]))),
      h("button", { type: "button", id: "again", onclick: again }, "read again"));
  }

  /** Offers the columns of a log; what was chosen stays if the log has it. */
  offer(columns, own = {}) {
    for (const [select, name] of [...this.axes.map((one, i) => [one, `m${AXES[i]}`]), [this.time, "t_s"]]) {
      const before = select.value;
      const source = Object.entries(own).find(([key]) => key.startsWith(name))?.[1];
      select.dataset.source = source ?? "";
      fill(select, h("option", { value: "" }, source ? `detect (${source})` : "detect"), columns.map((column) => h("option", { value: column }, column)));
      select.value = columns.includes(before) ? before : "";
    }
  }

  /** What was read, as the next choices. */
  took(said) {
    const own = Object.fromEntries(said.read_as.columns.map((column) => [column.name, column.source]));
    this.offer([...new Set([...Object.values(own), ...said.covariates])], own);
  }

  /** A new log: answers to the questions of the last one are not for it. */
  forget() {
    this.answers = [];
    for (const select of [...this.axes, this.time, this.unit, this.timeUnit]) select.value = "";
    this.scale.value = "";
  }

  /** The options for the reader. */
  asked(name) {
    const several = (option) => this.raw[option].value.split(";").map((one) => one.trim()).filter(Boolean);
    const one = (option) => this.raw[option].value.trim() || null;
    const answered = (option) => this.answers.filter(([own]) => own === option).map(([, value]) => value);
    const named = (select) => select.value || select.dataset.source || "";
    const columns = this.axes.some((select) => select.value) || this.unit.value ? mapped(this.axes.map(named), this.unit.value) : [];
    const time = (this.time.value || this.timeUnit.value) && named(this.time) ? [`t_s=${quoted(named(this.time))}${this.timeUnit.value ? `[${this.timeUnit.value}]` : ""}`] : [];
    return {
      name, map: [...several("map"), ...answered("--map"), ...columns, ...time], rotate: several("rotate"), repair: several("repair"), derive: several("derive"),
      ut_per_count: this.scale.value.trim() || answered("--ut-per-count").at(-1) || one("ut_per_count"), instance: one("instance") === null ? null : Number(one("instance")),
    };
  }

  get fieldUt() {
    return this.field.value.trim() ? Number(this.field.value) : null;
  }

  /** A question of the reader as a form; `answered` reads the log with the answer. */
  form(question, answered) {
    const choices = question.choices.map((choice, index) => h("p", {}, h("label", {}, h("input", { type: "radio", name: "answer", value: index, checked: index === 0 }), ` ${choice.label}`)));
    const selects = question.columns.length ? AXES.map((axis) => choose(`answer-${axis}`, [["", "choose"], ...question.columns.map((column) => [column, column])])) : [];
    const unit = selects.length ? choose("answer-unit", UNITS.slice(1)) : null;
    const scale = question.needs_scale || selects.length ? text("answer-scale", 8, { inputmode: "decimal", placeholder: "for example 0.15" }) : null;
    const missing = h("p", { class: "error", role: "alert", hidden: true });
    const read = () => {
      const given = [];
      const picked = [...choices].findIndex((one) => one.querySelector("input").checked);
      if (picked >= 0) given.push(...question.choices[picked].options);
      if (selects.length) given.push(...mapped(selects.map((one) => one.value), unit.value).map((map) => ["--map", map]));
      if (scale?.value.trim()) given.push(["--ut-per-count", scale.value.trim()]);
      missing.hidden = given.length > 0;
      fill(missing, "Choose an answer first.");
      if (!given.length) return;
      this.scale.value = "";
      // An answer takes the place of an earlier one about the same columns.
      const names = (map) => map.match(/[a-z_]+(?==)/g) ?? [];
      const own = given.flatMap(([option, value]) => (option === "--map" ? names(value) : [option]));
      this.answers = this.answers.filter(([option, value]) => !(option === "--map" ? names(value) : [option]).some((name) => own.includes(name)));
      this.answers.push(...given);
      answered();
    };
    return h("fieldset", { class: "question", id: "question" }, h("legend", {}, question.text), choices,
      selects.length ? h("div", { class: "form" }, selects.map((select, i) => row(`magnetometer ${AXES[i]}`, select)), row("unit", unit)) : null,
      scale ? h("div", { class: "form" }, row("scale, µT per count (only for counts)", scale)) : null, missing,
      h("button", { type: "button", id: "answer-read", onclick: read }, "read the log with this answer"));
  }
}
