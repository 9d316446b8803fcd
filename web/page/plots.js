// Plots: one way to draw them all, in the page's colours, each with its numbers as a table.
import uPlot from "./uplot.min.js";
import { fill, h, later, table } from "./dom.js";
import { significant } from "./numbers.js";
import { plotted, saver } from "./svg.js";

const HEIGHT = 240;
const ROWS = 40;
const all = new Set();
const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** For paper every plot is drawn as SVG, which is sharp at any size; afterwards that is taken away. */
export function onPaper(printing) {
  for (const plot of all) {
    if (plot.given) fill(plot.paper, printing ? plotted(plot.what, plot.given) : null);
  }
}

/** Draws every plot again: the theme has changed. */
export function redraw() {
  for (const plot of all) plot.draw();
}

const resized = new ResizeObserver((entries) => {
  for (const { target } of entries) target.plot?.fit();
});

export class Plot {
  /** `what` says it to those who do not see it; `id` names it. */
  constructor(id, what) {
    this.root = h("div", { class: "plot", id, role: "img", "aria-label": what, "data-what": what });
    this.numbers = h("div", { class: "no-print under" });
    this.paper = h("div", { class: "for-print" });
    this.save = saver(id.replace("plot-", ""), () => plotted(this.what, this.given));
    this.whole = h("figure", { class: "plot" }, h("figcaption", {}, what), this.root, this.paper, this.numbers);
    this.what = what;
    this.root.plot = this;
    all.add(this);
    resized.observe(this.root);
  }

  /**
   * Shows series over `x`: {label, values, colour, width, points, dash, fillTo}. `marks` are spans {from, to, text} shaded behind.
   * `axes` are {x, y, logX, logY}.
   */
  show(x, series, axes, marks = []) {
    this.given = { x, series, axes, marks };
    this.draw();
    fill(this.numbers, later("Numbers as a table", () => this.table()), this.save);
  }

  /** What is drawn now, as a table. */
  table() {
    const { x, series, axes } = this.given;
    const step = Math.max(1, Math.ceil(x.length / ROWS));
    const rows = [];
    for (let i = 0; i < x.length; i += step) rows.push([significant(x[i]), ...series.map((one) => significant(one.values[i], 3))]);
    return table(step > 1 ? `${this.what}; every ${step}th of ${x.length} points` : this.what,
      [axes.x, ...series.map((one) => one.label)], rows);
  }

  draw() {
    if (!this.given) return;
    const { x, series, axes, marks } = this.given;
    const width = this.root.clientWidth || 600;
    const stroke = style("--text");
    const grid = { stroke: style("--line"), width: 1 };
    const axis = (text, more) => ({ label: text, stroke, grid, ticks: grid, labelSize: 22, font: "12px system-ui", labelFont: "12px system-ui", ...more });
    const bands = [];
    series.forEach((one, index) => {
      if (one.fillTo !== undefined) bands.push({ series: [index + 1, one.fillTo + 1], fill: `${style(one.colour)}59` });
    });
    const options = {
      width, height: HEIGHT, legend: { live: true },
      cursor: { drag: { x: true, y: false } },
      scales: { x: { time: false, distr: axes.logX ? 3 : 1 }, y: { distr: axes.logY ? 3 : 1 } },
      axes: [axis(axes.x, { size: 34 }), axis(axes.y, { size: 58 })],
      series: [{ label: axes.x }, ...series.map((one) => ({
        label: one.label, stroke: style(one.colour), width: one.width ?? 1.5, dash: one.dash,
        paths: one.points ? () => null : undefined, spanGaps: false,
        points: { show: Boolean(one.points), size: one.points ?? 0, stroke: style(one.colour), fill: style(one.colour) },
      }))],
      bands,
      hooks: { drawClear: [(plot) => {
        plot.ctx.save();
        plot.ctx.fillStyle = `${style("--gap")}40`;
        for (const { from, to } of marks) {
          const [left, right] = [plot.valToPos(from, "x", true), plot.valToPos(to, "x", true)];
          plot.ctx.fillRect(Math.max(left, plot.bbox.left), plot.bbox.top, Math.max(2, right - left), plot.bbox.height);
        }
        plot.ctx.restore();
      }] },
    };
    this.plot?.destroy();
    this.plot = new uPlot(options, [x, ...series.map((one) => one.values)], this.root);
    this.root.dataset.drawn = String(Number(this.root.dataset.drawn ?? 0) + 1);
  }

  /** From now on [`stream`] draws only while it is seen. */
  watch() {
    new IntersectionObserver((all) => { this.unseen = !all.at(-1).isIntersecting; }).observe(this.root);
  }

  /** Shows a series that grows; cheaper than [`show`]. */
  stream(x, values, { label, ...axes }) {
    if (this.plot && this.unseen) return;
    if (this.plot && this.given?.growing) {
      this.given.x = x;
      this.given.series[0].values = values;
      this.plot.setData([x, values]);
      this.root.dataset.drawn = String(Number(this.root.dataset.drawn ?? 0) + 1);
      return;
    }
    this.given = { x, series: [{ label, values, colour: "--blue" }], axes, marks: [], growing: true };
    this.draw();
    fill(this.numbers, later("Numbers as a table (values when you open it)", () => this.table(), true), this.save);
  }

  fit() {
    const width = this.root.clientWidth;
    if (this.plot && width && width !== this.plot.width) this.plot.setSize({ width, height: HEIGHT });
  }
}

/** A band of least and greatest values as two series that are filled between. */
export function band(label, values, colour, place) {
  return [
    { label: `${label} (min)`, values: values.low, colour, width: 1 },
    { label: `${label} (max)`, values: values.high, colour, width: 1, fillTo: place },
  ];
}
