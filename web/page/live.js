// A board while it is turned: where to turn next, how good it is, what is missing. All of it is the board's own answers.
import { Board, values } from "./board.js";
import { Cloud } from "./cloud.js";
import { by, fill, h, save, table } from "./dom.js";
import { fixed } from "./numbers.js";
import { Readings } from "./readings.js";
import { Recording } from "./recording.js";
import { Strip } from "./strip.js";
import { sides, Turning } from "./turning.js";

const STATUS_MS = 700;
// Thirty times a second; a little less than a thirtieth, so that what comes in that beat waits for no second one.
const DRAW_MS = 30;
const SILENT_MS = 3000;
const TRANSCRIPT = 400;

/** What the monitor of a calibration in use has seen, where it is not well. */
const CONDITIONS = { disturbed: "something disturbs the field, or an effect is missing", outdated: "the calibration is outdated" };

const vector = (line, from) => line.split(",").slice(from, from + 3).map(Number);

/** An error with its unit: of the magnitude, or of the dip. */
// The board prints `-` if a value is unknown: then there is no unit either.
const sized = (ut, deg) => ([[ut, " µT"], [deg, "°"]].filter(([value]) => value !== undefined && value !== "-").map(([value, unit]) => value + unit)[0] ?? "–");

const meter = (id, label, low, high, max, best) => {
  const bar = h("meter", { id: `meter-${id}`, min: 0, max, low, high, optimum: best, value: 0, "aria-label": label });
  const text = h("span", { id: `value-${id}` }, "–");
  const parts = [h("span", {}, label), bar, text];
  for (const part of parts) part.hidden = true;
  return { bar, text, parts };
};

export class Live {
  /** `analyse` is asked to look at a log {name, text}. */
  constructor(analyse) {
    this.analyse = analyse;
    this.counts = { lines: 0, drawn: 0 };
    by("live").hidden = false;
    const button = (id, text, act) => h("button", { type: "button", id, disabled: true, onclick: () => this.act(act) }, text);
    this.state = h("p", { class: "state", id: "link", role: "status", "aria-live": "polite" }, "not connected");
    this.hint = h("p", { class: "hint", id: "hint", role: "status", "aria-live": "polite" });
    this.answer = h("p", { class: "note", id: "answer", role: "status", "aria-live": "polite" });
    this.meters = {
      coverage: meter("coverage", "directions seen, %", 0.3, 0.6, 1, 1),
      gap: meter("gap", "largest gap, °", 40, 90, 180, 0),
      error: meter("error", "predicted error, % (limit 1)", 1, 2, 4, 0),
    };
    this.readings = new Readings("reading");
    this.collected = h("p", { class: "state note", id: "collected" });
    this.judged = h("div", { id: "judged" });
    this.why = h("div", { id: "why" });
    this.buttons = {
      start: button("cal-start", "start", () => this.start()),
      stop: button("cal-stop", "stop and judge", () => this.stop()),
      accept: button("cal-accept", "accept", () => this.accept("")),
      force: button("cal-force", "accept anyway", () => this.accept(" force")),
      why: button("ask-why", "why is it off?", () => this.ask()),
      record: button("record-log", "record", () => this.record()),
      save: button("save-log", "save the recording", () => this.save()),
      look: button("look-log", "look at the recording", () => this.lookAt()),
    };
    this.buttons.force.hidden = true;
    this.transcript = h("pre", { class: "console", id: "console", tabindex: "0" });
    this.strip = new Strip("plot-live");
    this.turning = new Turning();
    const ball = h("div", { id: "live-ball" });
    fill(by("live-body"), this.state, h("div", { class: "where-to" }, this.hint, this.turning.root),
      h("div", { class: "buttons" }, Object.values(this.buttons)), this.answer,
      h("div", { class: "meter" }, Object.values(this.meters).flatMap((one) => one.parts)), this.collected, this.readings.root, this.judged, this.why,
      this.strip.plot.whole, ball,
      h("details", {}, h("summary", {}, "Console of the board"), this.transcript));
    this.cloud = new Cloud(ball, "live-sphere");
  }

  /** Follows a board until the page is closed. */
  async follow(wire) {
    this.wire = wire;
    this.board = new Board(wire, (what) => this.told(what));
    this.heard = performance.now();
    setInterval(() => this.watch(), 500);
    await wire.run((what) => {
      if (what.line !== undefined) {
        this.heard = performance.now();
        this.board.hear(what.line);
        return;
      }
      if (what.name) wire.name = what.name;
      if (what.open) this.opened().catch((error) => { if (this.connected) this.say(error.message, "silent"); });
      else this.gone(what.why);
    });
  }

  gone(why) {
    this.connected = false;
    // Whoever still asks who is there need not.
    this.turn = (this.turn ?? 0) + 1;
    this.board.gone(why);
    this.say(`${this.wire.name} is disconnected (${why}); waiting for it`, "gone");
    this.enable();
  }

  say(text, state) {
    if (this.state.textContent !== text) fill(this.state, text);
    this.state.dataset.state = state;
  }

  /** Says when nothing comes. */
  watch() {
    if (this.connected && performance.now() - this.heard > SILENT_MS) {
      this.say(`no data from ${this.wire.name} for ${fixed((performance.now() - this.heard) / 1000, 0)} s. Is the board powered?`, "silent");
      this.silent = true;
    } else if (this.silent && this.connected) {
      this.silent = false;
      this.introduce();
    }
  }

  introduce() {
    const { board, sensor, ironout } = this.who ?? {};
    this.say(this.who ? `${board} with ${sensor}, firmware ${ironout}, at ${this.wire.name}` : `${this.wire.name}: a sketch that prints Raw: lines`, "open");
  }

  async opened() {
    const turn = (this.turn ?? 0) + 1;
    this.turn = turn;
    this.heard = performance.now();
    this.say(`${this.wire.name} is open; who is there?`, "asking");
    this.who = null;
    for (let attempt = 0; !this.who && turn === this.turn; attempt += 1) {
      try {
        const reply = await this.board.ask(attempt ? "version" : "\nversion", { quiet: true, wait: 4000 });
        if (reply.all.ironout) this.who = reply.all;
      } catch (error) {
        if (this.sketch || turn !== this.turn) break;
        this.say(`${error.message}. Is the board powered, and does it run the firmware of ironout?`, "silent");
        await new Promise((resolve) => setTimeout(resolve, STATUS_MS));
      }
    }
    if (turn !== this.turn) return;
    this.connected = true;
    this.introduce();
    if (!this.who) {
      fill(this.hint, "Turn the board through as many directions as you can, then look at the recording.");
      this.enable();
      return;
    }
    this.scale = (this.who.ut_per_count ?? "1,1,1").split(",").map(Number);
    this.recording ??= new Recording(this.scale);
    if (!this.polling) this.poll();
    const status = await this.board.ask("status", { quiet: true });
    this.status(status);
    // A board that has a calibration shows what it is worth; one that has none, or collects, is recorded.
    await this.stream(status.all.calibrated === "1" && status.all.state === "idle" ? "cal" : "log");
    this.enable();
  }

  async stream(kind) {
    this.kind = kind;
    const reply = await this.board.ask(`stream ${kind}`);
    if (!reply.ok) fill(this.answer, reply.closing);
  }

  async poll() {
    this.polling = true;
    for (;;) {
      if (this.connected && this.who && !this.acting) {
        try {
          this.status(await this.board.ask("status", { quiet: true }));
        } catch {
          // The watch says it.
        }
      }
      await new Promise((resolve) => setTimeout(resolve, STATUS_MS));
    }
  }

  status(reply) {
    const { condition, residual_ratio: ratio } = values(reply.info.find((text) => text.startsWith("monitor ")) ?? "");
    const hints = [...reply.info.filter((text) => /^(hint|sensor|outside)/.test(text)).map((text) => text.replace(/^hint /, "")),
      ...(CONDITIONS[condition] ? [`${CONDITIONS[condition]}: the error is ${ratio} times the expected error`] : [])];
    if (this.hint.textContent !== hints.join(" · ")) fill(this.hint, hints.join(" · "));
    this.turning.show(reply.all.state === "collecting" ? sides(hints.join(" ")) : null);
    const { state, coverage, gap_deg: gap, rms_ut: rms, noise_ut: noise, n, calibrated } = reply.all;
    this.known = { state, calibrated: calibrated === "1" };
    document.body.dataset.board = state;
    document.body.dataset.calibrated = calibrated;
    // Idle, it counts for a calibration that there is not.
    const [part, hole] = state === "idle" ? [NaN, NaN] : [Number(coverage), Number(gap)];
    this.set("coverage", part, `${fixed(100 * Number(coverage), 0)} %`);
    this.set("gap", hole, `${fixed(Number(gap), 0)}°`);
    const collected = state === "collecting" ? [`${n} samples in the fit`, rms === "-" ? null : `residual ${rms} µT`, noise === "-" ? null : `noise ${noise} µT`].filter(Boolean).join(" · ") : "";
    if (this.collected.textContent !== collected) fill(this.collected, collected);
    this.enable();
    this.later();
  }

  set(name, value, text) {
    const { bar, text: at, parts } = this.meters[name];
    for (const part of parts) part.hidden = !Number.isFinite(value);
    bar.value = Number.isFinite(value) ? value : 0;
    fill(at, Number.isFinite(value) ? text : "–");
  }

  enable() {
    const { start, stop, accept, why, record, save: keep, look } = this.buttons;
    const board = this.connected && this.who && !this.acting;
    const state = this.known?.state;
    start.disabled = !board;
    stop.disabled = !board || state !== "collecting";
    accept.disabled = !board || state !== "solved";
    // The board studies from `cal start` on, whatever came of it, and in addition to a calibration.
    why.disabled = !board || !(this.known?.calibrated || ["collecting", "solved", "refused"].includes(state));
    // Without a calibration everything is recorded.
    record.disabled = !board || !this.known?.calibrated || state === "collecting";
    const text = this.kind === "log" && this.known?.calibrated ? "stop recording" : "record";
    if (record.textContent !== text) fill(record, text);
    keep.disabled = look.disabled = !(this.recording?.samples > 20);
  }

  /** Does what a button says; what goes wrong is said. */
  async act(what) {
    const held = document.activeElement;
    this.acting = true;
    this.enable();
    fill(this.answer, "…");
    try {
      await what();
    } catch (error) {
      fill(this.answer, error.message);
    }
    this.acting = false;
    this.enable();
    // A button that waits lets the keyboard go: it is given back.
    if (document.activeElement === document.body && held.isConnected) held.focus();
  }

  /** A command whose answer is shown. */
  async command(line) {
    const reply = await this.board.ask(line, { wait: 30000 });
    fill(this.answer, reply.ok ? `done: ${line}` : reply.closing);
    return reply;
  }

  async start() {
    this.clear();
    this.recording = new Recording(this.scale);
    fill(this.judged);
    fill(this.why);
    await this.stream("log");
    await this.command("cal start");
    this.known = { ...this.known, state: "collecting" };
  }

  async stop() {
    const reply = await this.command("cal stop");
    const found = reply.all;
    this.set("error", Number(found.error_percent), `${found.error_percent} %`);
    fill(this.judged, reply.ok ? table("Accepted. Press accept to store it", ["", "value", "limit"], [
      ["predicted error, % of the field", found.error_percent, "1"],
      ["residual, % of the field", found.rms_ut && found.field_ut ? fixed(100 * Number(found.rms_ut) / Number(found.field_ut), 3) : null, "5"],
      ["samples", found.n, ""], ["field strength, µT", found.field_ut, ""], ["noise, µT", found.noise_ut, ""],
    ].filter(([, value]) => value !== undefined && value !== "-" && value !== null)) : [reply.text.replace(/^refused \S+ /, "Refused: "), ...reply.info.map((text) => text.replace(/^also \S+ /, "Also: "))].map((text) => h("p", { class: "error" }, text)));
    this.known = { ...this.known, state: reply.ok ? "solved" : "refused" };
    document.body.dataset.board = this.known.state;
  }

  async accept(how) {
    const reply = await this.command(`cal accept${how}`);
    this.buttons.force.hidden = !(reply.text ?? "").includes("worse-than-in-use");
    this.buttons.force.disabled = this.buttons.force.hidden;
    if (!reply.ok) return;
    this.clear();
    await this.stream("cal");
  }

  async ask() {
    const reply = await this.command("why");
    const rows = reply.info.filter((text) => text.startsWith("effect ")).map(values);
    const says = reply.info.filter((text) => text.startsWith("says ")).map((text) => text.slice(5));
    const base = values(reply.info.find((text) => text.startsWith("base ")) ?? "");
    // The board refuses an effect for which the data give no evidence.
    const offer = { missing: "add", confounded: "add", "in-use": "remove" };
    const choice = ({ id, status }) => (offer[status]
      ? h("button", { type: "button", "data-effect-id": id, "aria-label": `${offer[status]} ${id}`, onclick: () => this.act(() => this.change(offer[status], id)) }, offer[status]) : null);
    fill(this.why, h("h3", {}, "Why is it off?"), says.map((text) => h("p", {}, text)), reply.ok ? null : h("p", { class: "error" }, reply.closing),
      rows.length ? table([["error now", base.rms_ut], ["held-out error", base.holdout_rms_ut], ["noise floor", base.noise_floor_ut]].filter(([, value]) => value !== undefined).map(([name, value]) => `${name} ${value} µT`).join(", "), ["effect", "status", "error before", "error after", "p-value", "not distinguishable from", ""],
        rows.map((row) => [row.id, row.status, sized(row.before_ut, row.before_deg), sized(row.after_ut, row.after_deg), row.p ?? "", row.confounded_with ?? "", choice(row) ?? ""])) : null);
    this.why.dataset.verdict = values(reply.text).verdict ?? "none";
  }

  /** Adds an effect to the calibration in use, or removes it; then asks again. */
  async change(how, id) {
    const reply = await this.command(`effect ${how} ${id}`);
    if (!reply.ok) return;
    this.clear();
    // What was judged before is in use no more.
    fill(this.judged);
    if (this.kind !== "cal") await this.stream("cal");
    await this.ask();
    this.why.querySelector(`[data-effect-id="${CSS.escape(id)}"]`)?.focus();
    const { rms_before_ut: before, rms_ut: after } = reply.all;
    fill(this.answer, `done: effect ${how} ${id}; what was learned has an error of ${before} µT before and ${after} µT after`);
  }

  /** Samples as measured instead of corrected ones, for a log; or corrected ones again. */
  async record() {
    this.clear();
    if (this.kind === "log") {
      await this.stream("cal");
      fill(this.answer, `${this.recording.samples} samples were recorded`);
      return;
    }
    this.recording = new Recording(this.scale);
    await this.stream("log");
    fill(this.answer, "recording what the sensor measures");
  }

  save() {
    save(this.who ? "log.csv" : "raw.txt", this.recording.text());
    fill(this.answer, `${this.recording.samples} samples were saved`);
  }

  async lookAt() {
    await this.analyse({ name: this.who ? "recording.csv" : "recording.txt", text: this.recording.text() });
    fill(this.answer, "below is what the recording shows");
  }

  /** What the board says unasked. */
  told({ stream, said, foreign }) {
    if (said) {
      this.lines = [...(this.lines ?? []), ...said].slice(-TRANSCRIPT);
      this.transcript.textContent = this.lines.join("\n");
      return;
    }
    if (foreign) return;
    this.counts.lines += 1;
    if (stream.startsWith("Raw:")) {
      this.sketch = !this.who;
      if (this.sketch) {
        this.recording ??= new Recording([0.1, 0.1, 0.1]);
        this.recording.take(stream);
        const v = stream.slice(4).split(",").slice(6, 9).map((value) => Number(value) / 10);
        if (v.every(Number.isFinite)) this.point(v);
      }
    } else if (stream.startsWith("L,") || stream.startsWith("H,")) {
      this.recording?.take(stream);
      const counts = vector(stream, 3);
      if (stream.startsWith("L,") && this.kind === "log" && counts.every(Number.isFinite)) this.point(counts.map((count, axis) => count * this.scale[axis]));
    } else if (stream.startsWith("C,")) {
      // An eighth cell says that the board is tilted further than its calibration is for.
      const cells = stream.split(",").slice(0, 7).map(Number);
      // A column that an effect needs may not be known: then there is no corrected value.
      [this.at, this.now] = [null, null];
      if (cells.slice(1).every(Number.isFinite)) {
        const [, ms, x, y, z, norm, residual] = cells;
        this.point([x, y, z]);
        this.now = { norm, residual, heading: ((Math.atan2(-y, x) * 180) / Math.PI + 360) % 360 };
        this.strip.take(ms / 1000, residual);
      }
    }
    this.later();
  }

  point(v) {
    this.at = v;
    this.cloud.take(v);
  }

  /** Nothing of what is drawn counts any more. */
  clear() {
    this.at = null;
    this.now = null;
    this.cloud.clear();
    this.strip.clear();
  }

  /** Draws soon, at most thirty times a second. */
  later() {
    if (this.timer) return;
    const since = performance.now() - (this.drawn ?? 0);
    this.timer = setTimeout(() => {
      this.timer = null;
      this.drawn = performance.now();
      this.draw();
    }, Math.max(0, DRAW_MS - since));
  }

  /** For a board that gives no hints of its own, the way to the nearest gap. */
  lead(now) {
    if (!this.sketch || (this.led && now - this.led < STATUS_MS)) return;
    this.led = now;
    const gap = this.cloud.gap();
    this.turning.show(gap);
    const words = gap ? `Bring the ${gap.names[0]} side to where the ${gap.names[1]} side is now.` : "Enough directions seen: look at the recording.";
    if (this.cloud.points.length > 20 && this.hint.textContent !== words) fill(this.hint, words);
  }

  draw() {
    this.counts.drawn += 1;
    const { dataset } = document.body;
    dataset.samples = String(this.counts.lines);
    dataset.drawn = String(this.counts.drawn);
    const corrected = this.kind === "cal";
    this.readings.show({ at: this.at, corrected, now: this.now, rms: this.strip.rms(), recorded: this.recording });
    const now = performance.now();
    this.strip.draw(now);
    this.lead(now);
    this.cloud.draw(now, corrected);
  }
}
