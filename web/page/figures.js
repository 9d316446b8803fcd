// A look at a log, drawn: everything but the switches.
import { by, fill, h, later, save, table } from "./dom.js";
import { chance, degrees, fixed, NONE, percent, significant, ut } from "./numbers.js";
import { band, Plot } from "./plots.js";
import { Sphere } from "./sphere.js";

const EXPORTS = [
  ["json", "cal.json", "CAL.json of ironout"], ["c", "calibration.h", "C header"], ["rust", "calibration.rs", "Rust"],
  ["px4", "mag.params", "PX4"], ["ardupilot", "mag.param", "ArduPilot"], ["betaflight", "betaflight.txt", "Betaflight"],
  ["ros", "magnetometer.yaml", "ROS 2"], ["iio", "iio.txt", "Linux IIO"],
];
const NEEDS_SCALE = ["betaflight", "iio"];

const figure = (id, title, value, ...lines) => h("div", { class: "figure" }, title, h("b", { id }, value), lines.map((line) => h("span", {}, line)));

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

  verdict() {
    const { figures, fit, sentence } = this.look;
    const more = this.found && this.look.asked.add.length === 0 && this.found.verdict !== "complete" ? this.found.sentence : null;
    fill(by("sentence"), sentence);
    fill(by("advice"), more);
    const parts = [];
    if (figures.before_ut !== null) {
      parts.push(figure("error-before", "error as measured", ut(figures.before_ut), percent(figures.before_percent),
        `heading ± ${degrees(figures.before_heading_deg)}`), h("span", { class: "arrow", "aria-hidden": "true" }, "→"));
    }
    if (figures.after_ut !== null) {
      parts.push(figure("error-now", fit.effects.length ? "error with what is switched on" : "error with offset and matrix", ut(figures.after_ut),
        percent(figures.after_percent), `heading ± ${degrees(figures.after_heading_deg)}`));
      const last = this.found?.steps?.at(-1);
      if (last && this.found.steps.length > 1 && fit.effects.length === 0) {
        parts.push(h("span", { class: "arrow", "aria-hidden": "true" }, "→"),
          figure("error-found", "error with what was found", ut(last.rms_ut), percent(100 * last.rms_ut / fit.field_ut),
            last.dip_rms_deg === null ? "" : `dip ± ${degrees(last.dip_rms_deg)}`));
      }
      parts.push(h("span", { class: "arrow", "aria-hidden": "true" }, "⊣"),
        figure("floor", "what noise alone leaves", ut(figures.floor_ut), percent(figures.floor_percent)));
    }
    fill(by("figures"), h("div", { class: "figures" }, parts));
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
      magnitude: new Plot("plot-magnitude", "Magnitude: measured, and as the model corrects it (µT over time)"),
      residual: new Plot("plot-residual", "Error of the corrected magnitude over time (µT)"),
      dip: new Plot("plot-dip", "Dip of the corrected field against gravity over time (degrees)"),
      heading: new Plot("plot-heading", "Heading minus its reference over time (degrees)"),
    };
    const spans = this.look.faults.filter((fault) => fault.from_s !== null).map((fault) => ({ from: fault.from_s, to: fault.to_s }));
    const body = by("time-body");
    if (!body.firstChild) fill(body, h("p", { class: "note", id: "faults" }), Object.values(this.times).map((plot) => plot.whole));
    fill(by("faults"), this.look.faults.length
      ? `Shaded, and left out of the fit: ${this.look.faults.map((fault) => `${fault.kind} ${fault.from_s === null ? "" : `${fixed(fault.from_s, 1)} to ${fixed(fault.to_s, 1)} s`}${fault.columns.length ? ` (${fault.columns.join(", ")})` : ""}`).join("; ")}.`
      : "No faults of the data.");
    const x = timeline.at_s;
    const add = (values) => ({ low: values.low.map((v) => v === null ? null : v + field), high: values.high.map((v) => v === null ? null : v + field) });
    const seconds = "time, s";
    this.times.magnitude.show(x, [...band("measured", timeline.measured_ut, "--orange", 0), ...band("corrected", add(timeline.residual_ut), "--blue", 2),
      { label: "model", values: x.map(() => field), colour: "--text", dash: [6, 4] }], { x: seconds, y: "µT" }, spans);
    const effects = this.look.fit.effects.length > 0;
    this.times.residual.show(x, [...(effects ? band("offset and matrix only", timeline.without_ut, "--orange", 0) : []),
      ...band(effects ? "with what is switched on" : "offset and matrix", timeline.residual_ut, "--blue", effects ? 2 : 0)], { x: seconds, y: "µT" }, spans);
    for (const [key, values, unit] of [["dip", timeline.dip_deg, "°"], ["heading", timeline.heading_error_deg, "°"]]) {
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
      this.columnPlot = new Plot("plot-column", "Error against the chosen column, rms in bins (µT)");
      this.columnDots = new Plot("plot-dots", "Error of each sample against the chosen column (µT)");
      this.explains = h("p", { class: "note" });
      fill(body, h("label", {}, "Error against ", this.columns), this.explains, h("div", { class: "pair" }, this.columnPlot.whole, this.columnDots.whole));
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
    const place = bins.unit ? `${bins.name}, ${bins.unit}` : bins.name;
    const effects = this.look.fit.effects.length > 0;
    const found = this.found?.where?.find((one) => one.against === bins.name);
    fill(this.explains, found ? `Of the squared error of offset and matrix it explains ${fixed(100 * found.explained, 0)} %; chance does as well with probability ${chance(found.p_value)}.` : "");
    const floor = this.look.figures.floor_ut;
    this.columnPlot.show(bins.at, [
      { label: "offset and matrix only", values: bins.without_ut, colour: "--orange", points: 7 },
      ...(effects ? [
        { label: "with the effects", values: bins.effect_ut, colour: "--text", width: 2, dash: [7, 4] },
        { label: "with what is switched on", values: bins.rms_ut, colour: "--blue", points: 7 },
      ] : []),
      ...(floor === null ? [] : [{ label: "noise alone", values: bins.at.map(() => floor), colour: "--grey", dash: [2, 3] }]),
    ], { x: place, y: "rms, µT" });
    const order = this.cloud.columns[index].map((_, i) => i).filter((i) => this.cloud.columns[index][i] !== null)
      .sort((a, b) => this.cloud.columns[index][a] - this.cloud.columns[index][b]);
    const pick = (values) => order.map((i) => values[i]);
    this.columnDots.show(pick(this.cloud.columns[index]), [
      { label: "offset and matrix only", values: pick(this.cloud.without_ut), colour: "--orange", points: 2.5 },
      ...(effects ? [{ label: "with what is switched on", values: pick(this.cloud.residual_ut), colour: "--blue", points: 2.5 }] : []),
    ], { x: place, y: "µT" });
  }

  noise() {
    const { spectrum, histogram } = this.look.picture;
    by("noise").hidden = !spectrum && !histogram;
    if (!this.spectrum) {
      this.spectrum = new Plot("plot-spectrum", "Spectrum of the error (µT/√Hz over Hz)");
      this.histogram = new Plot("plot-histogram", "How often errors of each size are, against noise alone");
      fill(by("noise-body"), this.spectrum.whole, this.histogram.whole);
    }
    const effects = this.look.fit.effects.length > 0;
    this.spectrum.whole.hidden = !spectrum;
    const positive = (values) => values.map((value) => (value > 0 ? value : null));
    if (spectrum) {
      this.spectrum.show(spectrum.hz, [
        { label: "offset and matrix only", values: positive(spectrum.without), colour: "--orange" },
        ...(effects ? [{ label: "with what is switched on", values: positive(spectrum.with), colour: "--blue" }] : []),
        ...(spectrum.noise ? [{ label: "noise alone", values: spectrum.hz.map(() => spectrum.noise), colour: "--grey", dash: [4, 3] }] : []),
      ], { x: "Hz", y: "µT/√Hz", logX: true, logY: true });
    }
    this.histogram.whole.hidden = !histogram;
    if (histogram) {
      this.histogram.show(histogram.at_ut, [
        { label: "offset and matrix only", values: histogram.without, colour: "--orange" },
        ...(effects ? [{ label: "with what is switched on", values: histogram.with, colour: "--blue" }] : []),
        ...(histogram.noise.length ? [{ label: "noise alone", values: histogram.noise, colour: "--grey", dash: [4, 3] }] : []),
      ], { x: "error, µT", y: "share" });
    }
  }

  numbers() {
    const { fit, figures, effects, alignment } = this.look;
    by("numbers").hidden = false;
    const parts = [];
    if (fit.offset_ut) {
      const errors = fit.std_errors;
      const row = (name, values, sigma, decimals) => [name, ...values.map((value, i) => `${fixed(value, decimals)} ± ${fixed(sigma?.[i] ?? null, decimals)}`)];
      parts.push(table("Offset and matrix: corrected = matrix · (measured − offset" + (fit.effects.length ? " − effects)" : ")"), ["", "x", "y", "z"], [
        row("offset, µT", fit.offset_ut, errors?.offset_ut, 3),
        ...fit.matrix.map((values, i) => row(`matrix ${"xyz"[i]}`, values, errors?.matrix[i], 5)),
      ]));
    }
    for (const effect of effects) {
      const fixedAt = [...effect.reference.map(([name, value]) => `none at ${name} = ${significant(value)}`), ...effect.parameters.map(([name, value]) => `${name} = ${fixed(value, 4)}`)];
      parts.push(h("h3", {}, `${effect.name} (${effect.id})`), h("p", {}, effect.explanation),
        h("p", {}, effect.amount ? `It amounts to ${effect.amount}.` : "", fixedAt.length ? ` ${fixedAt.join(", ")}.` : ""),
        table(`Coefficients of ${effect.id}, ${effect.unit}`, ["", "value", "± 1σ"], effect.coefficients.map((value, i) => [`${i + 1}`, significant(value), significant(effect.std_errors[i])])));
      const partners = this.found?.candidates?.find((one) => one.id === effect.id)?.confounded_with ?? [];
      if (partners.length) parts.push(h("p", { class: "note" }, `In this log it cannot be told from ${partners.join(", ")}: ${this.found.candidates.find((one) => one.id === effect.id).why}`));
    }
    parts.push(table("Figures of the fit", ["", "µT", "% of the field"], [
      ["error as measured", fixed(figures.before_ut, 3), fixed(figures.before_percent, 2)],
      ["error after", fixed(fit.rms_ut, 3), fixed(figures.after_percent, 2)],
      ["on unseen time", fixed(fit.holdout_rms_ut, 3), fixed(fit.field_ut ? 100 * fit.holdout_rms_ut / fit.field_ut : null, 2)],
      ["floor by noise", fixed(figures.floor_ut, 3), fixed(figures.floor_percent, 2)],
      ["sensor noise per axis", fixed(fit.noise_floor_ut, 3), NONE],
      ["predicted error of a vector", fixed(figures.predicted_ut, 3), fixed(fit.field_ut ? 100 * figures.predicted_ut / fit.field_ut : null, 2)],
      ["field", fixed(fit.field_ut, 3), NONE],
    ]), h("p", { class: "note" }, `${fit.samples_used} samples used, ${fit.samples_set_aside} set aside, ${figures.repeated} repeated, ${figures.at_rest} at rest. ` +
      `Dip ${fixed(figures.dip_deg, 1)}°.` + (alignment ? ` Aligned to the accelerometer: turned by ${fixed(alignment.angle_deg, 2)}°, spread of the dip ${fixed(alignment.dip_before_deg, 2)}° → ${fixed(alignment.dip_after_deg, 2)}°.` : "")));
    if (fit.reasons.length) parts.push(h("ul", {}, fit.reasons.map((reason) => h("li", {}, reason))));
    fill(by("numbers-body"), parts);
  }

  open() {
    const untested = (this.found?.candidates ?? []).filter((one) => one.status === "untestable");
    by("open").hidden = !this.found;
    if (!this.found) return;
    fill(by("open-body"), untested.length
      ? [h("p", {}, "What could not be tested, and what would let it be:"), table("Candidates that this log cannot test", ["effect", "why"], untested.map((one) => [`${one.name} (${one.id})`, one.why]))]
      : h("p", {}, "Every effect of the catalogue could be tested with this log."));
  }

  exports() {
    by("export").hidden = false;
    const { cal } = this.look;
    if (!cal) {
      fill(by("export-body"), h("p", { class: "note" }, "A refused calibration is not written."));
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
      h("label", { class: "note" }, "µT a count of the target's driver, for Betaflight and IIO ", scale), status, text);
  }

  words() {
    by("words").hidden = false;
    const lines = (title, text) => h("details", {}, h("summary", {}, title), h("pre", { tabindex: "0" }, text));
    fill(by("words-body"),
      this.said?.read_words ? lines("How the log was read", this.said.read_words + this.said.notices.map((notice) => `note: ${notice}\n`).join("")) : null,
      lines("The fit, as ironout fit prints it", this.look.words),
      this.found?.words ? lines("The diagnosis, as ironout diagnose prints it", this.found.words) : null);
  }
}
