// A look at a log, drawn: everything but the switches.
import { by, fill, h, later, save, table } from "./dom.js";
import { chance, degrees, fixed, labelled, percent, significant, ut } from "./numbers.js";
import { band, Plot } from "./plots.js";
import { Sphere } from "./sphere.js";

const EXPORTS = [
  ["json", "cal.json", "CAL.json of ironout"], ["c", "calibration.h", "C header"], ["rust", "calibration.rs", "Rust"],
  ["px4", "mag.params", "PX4"], ["ardupilot", "mag.param", "ArduPilot"], ["betaflight", "betaflight.txt", "Betaflight"],
  ["ros", "magnetometer.yaml", "ROS 2"], ["iio", "iio.txt", "Linux IIO"],
];
const NEEDS_SCALE = ["betaflight", "iio"];

/** What the page calls each verdict. */
const VERDICT = { MISSING: "FOUND" };

const figure = (id, title, value, ...lines) => h("div", { class: "figure" }, title, h("b", { id }, value), lines.filter(Boolean).map((line) => h("span", {}, line)));
const heading = (value) => (value === null ? null : `heading ± ${degrees(value)} (1σ)`);
const ofField = (value) => `${percent(value)} of the field`;
const arrow = () => h("span", { class: "arrow", "aria-hidden": "true" }, "→");

export class Figures {
  constructor(engine) {
    this.engine = engine;
  }

  /** Shows a look at a log; `said` is what is known of the log, `found` the diagnosis. */
  show(look, said, found) {
    Object.assign(this, { look, said, found });
    this.verdict();
    this.sphere();
    this.time();
    this.against();
    this.noise();
    this.numbers();
    this.open();
    this.exports();
    this.words();
  }

  /** A new log: the column that explains most is shown first again. */
  forget() {
    if (this.columns) this.columns.value = "";
  }

  verdict() {
    const { figures, fit, verdict } = this.look;
    const name = VERDICT[verdict.name] ?? verdict.name;
    fill(by("log-name"), h("strong", {}, this.said?.name ?? "log"), this.source());
    // The first sentence is the headline.
    const [first, ...rest] = verdict.sentence.split(/(?<=\.) (?=[A-Z0-9])/);
    fill(by("sentence"), h("span", { class: "badge", "data-verdict": name }, name), ` ${first.charAt(0).toUpperCase()}${first.slice(1)}`,
      rest.length ? h("span", { class: "rest" }, ` ${rest.join(" ")}`) : null);
    fill(by("advice"), verdict.calibration);
    const parts = [];
    if (figures.before_ut !== null) {
      parts.push(figure("error-before", "error as measured", ut(figures.before_ut), ofField(figures.before_percent)), arrow());
    }
    const effects = fit.effects.length > 0;
    if (effects && figures.without_effects_ut !== null && fit.field_ut) {
      parts.push(figure("error-base", "error with offset and matrix", ut(figures.without_effects_ut), ofField((100 * figures.without_effects_ut) / fit.field_ut)), arrow());
    }
    if (figures.after_ut !== null) {
      parts.push(figure("error-now", effects ? `error with ${fit.effects.length === 1 ? fit.effects[0].id : `${fit.effects.length} effects added`}` : "error with offset and matrix", ut(figures.after_ut),
        ofField(figures.after_percent), heading(figures.after_heading_deg)));
    }
    if (figures.floor_ut !== null) parts.push(figure("floor", "noise floor", ut(figures.floor_ut), ofField(figures.floor_percent)));
    fill(by("figures"), h("div", { class: "figures" }, parts));
  }

  /** What was read: rows, seconds, format. */
  source() {
    const { rows, seconds, read_as: read } = this.said ?? {};
    const parts = [rows && `${rows} rows`, typeof seconds === "number" && `${fixed(seconds, seconds < 10 ? 1 : 0)} s`, read?.format].filter(Boolean);
    return parts.length ? ` · ${parts.join(" · ")}` : null;
  }

  sphere() {
    by("ball").hidden = false;
    this.ball ??= new Sphere(by("ball-body"));
    this.ball.show(this.look.picture);
  }

  time() {
    const { timeline, field_ut: field } = this.look.picture;
    by("over-time").hidden = !timeline;
    if (!timeline) return;
    this.times ??= {
      magnitude: new Plot("plot-magnitude", "Magnitude of the field: measured and corrected (µT)"),
      residual: new Plot("plot-residual", "Residual: error of the corrected magnitude (µT)"),
      dip: new Plot("plot-dip", "Dip: angle of the corrected field below the horizon (°)"),
      heading: new Plot("plot-heading", "Heading minus its reference (°)"),
    };
    const spans = this.look.faults.filter((fault) => fault.from_s !== null).map((fault) => ({ from: fault.from_s, to: fault.to_s }));
    const body = by("time-body");
    if (!body.firstChild) fill(body, h("p", { class: "note", id: "faults" }), Object.values(this.times).map((plot) => plot.whole));
    fill(by("faults"), this.look.faults.length
      ? `The fit does not use the shaded times: ${this.look.faults.map((fault) => `${fault.kind} ${fault.from_s === null ? "" : `${fixed(fault.from_s, 1)} to ${fixed(fault.to_s, 1)} s`}${fault.columns.length ? ` (${fault.columns.join(", ")})` : ""}`).join("; ")}.`
      : "No faults in the data.");
    const x = timeline.at_s;
    const add = (values) => ({ low: values.low.map((v) => v === null ? null : v + field), high: values.high.map((v) => v === null ? null : v + field) });
    const seconds = "time, s";
    this.times.magnitude.show(x, [...band("measured", timeline.measured_ut, "--orange", 0), ...band("corrected", add(timeline.residual_ut), "--blue", 2),
      { label: "model", values: x.map(() => field), colour: "--text", dash: [6, 4] }], { x: seconds, y: "magnitude, µT" }, spans);
    const effects = this.look.fit.effects.length > 0;
    this.times.residual.show(x, [...(effects ? band("offset and matrix", timeline.without_ut, "--orange", 0) : []),
      ...band(effects ? "with effects" : "offset and matrix", timeline.residual_ut, "--blue", effects ? 2 : 0)], { x: seconds, y: "residual, µT" }, spans);
    for (const [key, values, unit] of [["dip", timeline.dip_deg, "dip, °"], ["heading", timeline.heading_error_deg, "heading error, °"]]) {
      this.times[key].whole.hidden = !values;
      if (values) this.times[key].show(x, band(key === "dip" ? "dip" : "heading − reference", values, "--green", 0), { x: seconds, y: unit }, spans);
    }
  }

  against() {
    const { against, cloud } = this.look.picture;
    by("against").hidden = against.length === 0;
    if (against.length === 0) return;
    const body = by("against-body");
    if (!this.columns) {
      this.columns = h("select", { id: "column", onchange: () => this.column() });
      this.columnPlot = new Plot("plot-column", "Residual against the chosen column: rms per bin (µT)");
      this.columnDots = new Plot("plot-dots", "Residual against the chosen column: samples (µT)");
      this.explains = h("p", { class: "note" });
      fill(body, h("label", {}, "Residual against ", this.columns), this.explains, h("div", { class: "pair" }, this.columnPlot.whole, this.columnDots.whole));
    }
    // What explains most comes first where a search says so.
    const rank = (name) => {
      const found = this.found?.where?.find((one) => one.against === name);
      return found ? found.explained : 0;
    };
    const chosen = this.columns.value;
    const order = against.map((_, index) => index).sort((a, b) => rank(against[b].name) - rank(against[a].name));
    fill(this.columns, order.map((index) => h("option", { value: against[index].name }, against[index].name)));
    if (against.some((one) => one.name === chosen)) this.columns.value = chosen;
    this.cloud = cloud;
    this.column();
  }

  column() {
    const index = this.look.picture.against.findIndex((one) => one.name === this.columns.value);
    const bins = this.look.picture.against[index];
    const place = labelled(bins.name, bins.unit);
    const effects = this.look.fit.effects.length > 0;
    const found = this.found?.where?.find((one) => one.against === bins.name);
    fill(this.explains, found ? `${bins.name} explains ${fixed(100 * found.explained, 0)} % of the residual variance of offset and matrix (p ${chance(found.p_value).startsWith("<") ? "" : "= "}${chance(found.p_value)}).` : "");
    const floor = this.look.figures.floor_ut;
    this.columnPlot.show(bins.at, [
      { label: "offset and matrix", values: bins.without_ut, colour: "--orange", points: 9 },
      ...(effects ? [
        { label: "effects (model)", values: bins.effect_ut, colour: "--text", width: 2, dash: [7, 4] },
        { label: "with effects", values: bins.rms_ut, colour: "--blue", points: 9 },
      ] : []),
      ...(floor === null ? [] : [{ label: "noise alone", values: bins.at.map(() => floor), colour: "--grey", dash: [2, 3] }]),
    ], { x: place, y: "residual rms, µT" });
    const order = this.cloud.columns[index].map((_, i) => i).filter((i) => this.cloud.columns[index][i] !== null)
      .sort((a, b) => this.cloud.columns[index][a] - this.cloud.columns[index][b]);
    const pick = (values) => order.map((i) => values[i]);
    this.columnDots.show(pick(this.cloud.columns[index]), [
      { label: "offset and matrix", values: pick(this.cloud.without_ut), colour: "--orange", points: 4 },
      ...(effects ? [{ label: "with effects", values: pick(this.cloud.residual_ut), colour: "--blue", points: 4 }] : []),
    ], { x: place, y: "residual, µT" });
  }

  noise() {
    const { spectrum, histogram } = this.look.picture;
    by("noise").hidden = !spectrum && !histogram;
    if (!this.spectrum) {
      this.spectrum = new Plot("plot-spectrum", "Spectrum of the residual (µT/√Hz)");
      this.histogram = new Plot("plot-histogram", "Histogram of the residual (dashed: noise alone)");
      fill(by("noise-body"), this.spectrum.whole, this.histogram.whole);
    }
    const effects = this.look.fit.effects.length > 0;
    this.spectrum.whole.hidden = !spectrum;
    const positive = (values) => values.map((value) => (value > 0 ? value : null));
    if (spectrum) {
      this.spectrum.show(spectrum.hz, [
        { label: "offset and matrix", values: positive(spectrum.without), colour: "--orange" },
        ...(effects ? [{ label: "with effects", values: positive(spectrum.with), colour: "--blue" }] : []),
        ...(spectrum.noise ? [{ label: "noise alone", values: spectrum.hz.map(() => spectrum.noise), colour: "--grey", dash: [4, 3] }] : []),
      ], { x: "frequency, Hz", y: "residual, µT/√Hz", logX: true, logY: true });
    }
    this.histogram.whole.hidden = !histogram;
    if (histogram) {
      this.histogram.show(histogram.at_ut, [
        { label: "offset and matrix", values: histogram.without, colour: "--orange" },
        ...(effects ? [{ label: "with effects", values: histogram.with, colour: "--blue" }] : []),
        ...(histogram.noise.length ? [{ label: "noise alone", values: histogram.noise, colour: "--grey", dash: [4, 3] }] : []),
      ], { x: "residual, µT", y: "share of samples" });
    }
  }

  numbers() {
    const { fit, figures, effects, alignment } = this.look;
    by("numbers").hidden = false;
    const parts = [];
    if (fit.offset_ut) {
      const errors = fit.std_errors;
      const known = (value) => typeof value === "number" && Number.isFinite(value);
      const row = (name, values, sigma, decimals) => [name, ...values.map((value, i) => `${fixed(value, decimals)}${known(sigma?.[i]) ? ` ± ${fixed(sigma[i], decimals)}` : ""}`)];
      parts.push(table("Offset and matrix with standard errors (1σ): corrected = matrix · (measured − offset" + (fit.effects.length ? " − effects)" : ")"), ["", "x", "y", "z"], [
        row("offset, µT", fit.offset_ut, errors?.offset_ut, 3),
        ...fit.matrix.map((values, i) => row(`matrix ${"xyz"[i]}`, values, errors?.matrix[i], 5)),
      ]));
    }
    for (const effect of effects) {
      const fixedAt = [...effect.reference.map(([name, value]) => `zero at ${name} = ${significant(value)}`), ...effect.parameters.map(([name, value]) => `${name} = ${fixed(value, 4)}`)];
      parts.push(h("h3", {}, `${effect.name} (${effect.id})`), h("p", {}, effect.explanation),
        effect.amount || fixedAt.length ? h("p", {}, effect.amount ? `Size: ${effect.amount}.` : "", fixedAt.length ? ` ${fixedAt.join(", ")}.` : "") : null,
        table(`Coefficients of ${effect.id} in ${effect.unit}`, ["", `value, ${effect.unit}`, `standard error, ${effect.unit}`], effect.coefficients.map((value, i) => [effect.names[i], significant(value), significant(effect.std_errors[i], 2)])));
      const partners = this.found?.candidates?.find((one) => one.id === effect.id)?.confounded_with ?? [];
      if (partners.length) parts.push(h("p", { class: "note" }, `In this log ${effect.id} cannot be distinguished from ${partners.join(", ")}: ${this.found.candidates.find((one) => one.id === effect.id).why}`));
    }
    const share = (value) => (typeof value === "number" && fit.field_ut ? (100 * value) / fit.field_ut : null);
    const rows = [
      ["error as measured", figures.before_ut, figures.before_percent], ["error with offset and matrix", figures.without_effects_ut, share(figures.without_effects_ut)],
      ["error after correction", fit.rms_ut, figures.after_percent], ["held-out error (10-fold)", fit.holdout_rms_ut, share(fit.holdout_rms_ut)],
      ["noise floor", figures.floor_ut, figures.floor_percent], ["sensor noise per axis", fit.noise_floor_ut, share(fit.noise_floor_ut)],
      ["predicted error of a corrected vector", figures.predicted_ut, share(figures.predicted_ut)], ["field strength", fit.field_ut, null],
    ].filter(([, value]) => typeof value === "number");
    const counts = [[fit.samples_used, "samples used"], [fit.samples_set_aside, "set aside"], [figures.repeated, "repeated"], [figures.at_rest, "at rest"]];
    parts.push(table("Figures of the fit", ["", "µT", "% of the field"], rows.map(([name, value, part]) => [name, fixed(value, 3), part === null ? "" : fixed(part, 2)])),
      h("p", { class: "note" }, `${counts.filter(([count], index) => index === 0 || count).map(([count, words]) => `${count} ${words}`).join(", ")}.` +
        (typeof figures.dip_deg === "number" ? ` Dip ${fixed(figures.dip_deg, 1)}°.` : "") +
        (alignment ? ` The axes are aligned to the accelerometer (turned by ${fixed(alignment.angle_deg, 2)}°): the spread of the dip falls from ${fixed(alignment.dip_before_deg, 2)}° to ${fixed(alignment.dip_after_deg, 2)}°.` : "")));
    if (fit.reasons.length) parts.push(h("ul", {}, fit.reasons.map((reason) => h("li", {}, reason))));
    fill(by("numbers-body"), parts);
  }

  open() {
    const untested = (this.found?.candidates ?? []).filter((one) => one.status === "untestable");
    by("open").hidden = !this.found;
    if (!this.found) return;
    fill(by("open-body"), untested.length
      ? [h("p", {}, "These effects cannot be tested with this log:"), table("Effects that cannot be tested with this log, and why", ["effect", "why"], untested.map((one) => [`${one.name} (${one.id})`, one.why]))]
      : h("p", {}, "ironout could test every effect of the catalogue on this log."));
  }

  exports() {
    by("export").hidden = false;
    const { cal } = this.look;
    if (!cal) {
      fill(by("export-body"), h("p", { class: "note" }, `${this.look.verdict.calibration} A refused calibration is not exported.`));
      return;
    }
    const text = h("pre", { id: "exported", tabindex: "0", hidden: true });
    const status = h("p", { role: "status", class: "note" });
    const scale = h("input", { type: "text", id: "scale", size: "10", placeholder: "0.15" });
    const make = async ([form, name]) => {
      fill(status, "");
      try {
        const question = { do: "export", cal, form, place: NEEDS_SCALE.includes(form) || ["px4", "ardupilot", "ros"].includes(form) ? this.place ?? 0 : null };
        if (NEEDS_SCALE.includes(form) && scale.value) question.ut_per_count = scale.value;
        const exported = form === "json" ? cal : (await this.engine.ask(question)).text;
        text.hidden = false;
        fill(text, exported);
        text.dataset.form = form;
        save(name, exported);
      } catch (error) {
        text.hidden = true;
        fill(status, error.message);
      }
    };
    fill(by("export-body"), h("div", { class: "buttons" }, EXPORTS.map((one) => h("button", { type: "button", "data-form": one[0], onclick: () => make(one) }, one[2]))),
      h("label", { class: "note" }, "For Betaflight and Linux IIO: scale of the target's driver, µT per count ", scale), status, text);
  }

  words() {
    by("words").hidden = false;
    const lines = (title, text) => h("details", {}, h("summary", {}, title), h("pre", { tabindex: "0" }, text));
    fill(by("words-body"),
      this.said?.read_words ? lines("How the log was read", this.said.read_words + this.said.notices.map((notice) => `note: ${notice}\n`).join("")) : null,
      lines(`ironout fit${this.look.asked.add.map((id) => ` --add ${id}`).join("")}`, this.look.words),
      this.found?.words ? lines("ironout diagnose", this.found.words) : null);
  }
}
