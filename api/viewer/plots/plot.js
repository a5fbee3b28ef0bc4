// A plot of curves: cursor shared with its neighbours, marker of the shown time, CSV, PNG, and the same as a table.

import uPlot from "../vendor/uplot/uPlot.esm.js";
import { button, html, saveFile, table } from "../dom.js";
import { commaSeparated, number } from "../format.js";
import { LabelPlaces } from "./label_places.js";

/** Colours after Okabe and Ito, which the colour-blind can distinguish; and dashes, for those without any colour. */
const COLOURS = ["#0072b2", "#d55e00", "#00805f", "#b0508c", "#8a6d00", "#333333", "#56b4e9"];
const DASHES = [[], [9, 4], [2, 3], [9, 3, 2, 3], [14, 5], [5, 3], [1, 2]];
const MOST_ROWS = 200;
const HEIGHT = 250;

/** The look of the curve number `index`. */
export function lineStyle(index) {
  return { stroke: COLOURS[index % COLOURS.length], dash: DASHES[index % DASHES.length] };
}

export class Plot {
  element;
  #options;
  #chart = null;
  #marked = null;
  #rows;
  #watcher;

  /**
   * `x` {label, unit, values}; `curves` [{label, values, style?, width?, end?}], null where there is no value, `end` the last x of what it
   * is a curve of; `y` {label, unit};
   * `group` names the plots that share a cursor; `onSeek(x)` when a place is clicked; `levels` [{value, label}] horizontal lines.
   */
  constructor(options) {
    this.#options = options;
    const { title, note } = options;
    this.holder = html("div", { class: "plot-area", role: "img", "aria-label": `${title}; the numbers are in the table below` });
    this.#rows = html("details", { class: "numbers", ontoggle: () => this.#fillTable() }, html("summary", {}, "Table"));
    this.element = html(
      "figure",
      { class: "plot" },
      html(
        "figcaption",
        {},
        html("span", {}, html("strong", {}, title), note ? html("small", {}, ` ${note}`) : null),
        html("span", { class: "tools" },
          button("CSV", () => saveFile(`${this.#fileName()}.csv`, this.csv(), "text/csv"), { "aria-label": `${title} as CSV` }),
          button("PNG", () => this.#savePicture(), { "aria-label": `${title} as PNG` })),
      ),
      this.holder,
      this.#rows,
    );
    this.#watcher = new ResizeObserver(() => this.#resize());
    this.#watcher.observe(this.holder);
  }

  #fileName() {
    return `${this.#options.name ?? "contuse"}-${this.#options.title.toLowerCase().replace(/[^a-z0-9]+/g, "-")}`;
  }

  /** Shows other values of the same curves. */
  setData(x, curves) {
    this.#options.x.values = x;
    curves.forEach((values, i) => (this.#options.curves[i].values = values));
    this.#chart?.setData(this.#data());
    this.#fillTable();
  }

  #data() {
    return [this.#options.x.values, ...this.#options.curves.map((curve) => curve.values)];
  }

  #resize() {
    const width = this.holder.clientWidth;
    if (!width) return;
    if (this.#chart) this.#chart.setSize({ width, height: HEIGHT });
    else this.#chart = new uPlot(this.#chartOptions(width), this.#data(), this.holder);
  }

  #chartOptions(width) {
    const { x, y, curves, group, range } = this.#options;
    const axis = { font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", stroke: "#33475b", grid: { stroke: "#e3e8ee", width: 1 }, ticks: { stroke: "#c3ccd6" } };
    const named = ({ label, unit }) => (unit ? `${label} [${unit}]` : label);
    const shown = (unit) => (_, value) => (value == null ? "–" : `${number(value)}${unit ? ` ${unit}` : ""}`);
    const read = (curve) => (u, value, _, i) => {
      if (i != null && x.values[i] > curve.end) return `ended at ${shown(x.unit)(u, curve.end)}`;
      return shown(y.unit)(u, i == null || !curve.style?.spanGaps ? value : valueNear(curve.values, i));
    };
    return {
      width,
      height: HEIGHT,
      scales: { x: { time: false }, ...(range && { y: { range } }) },
      cursor: { ...(group && { sync: { key: group } }), bind: { click: (u, _, next) => (event) => this.#seek(u, event, next) } },
      axes: [
        { ...axis, label: named(x), labelSize: 22, size: 34 },
        { ...axis, label: named(y), labelSize: 20, size: (_, ticks) => widthOf(ticks), values: (_, ticks) => ticks.map((t) => plainTick(t)) },
      ],
      series: [
        { label: x.label, value: shown(x.unit) },
        ...curves.map((curve, i) => ({
          label: curve.label,
          width: curve.width ?? 2,
          points: { show: false },
          value: read(curve),
          ...lineStyle(i),
          ...curve.style,
        })),
      ],
      legend: { markers: { dash: (_, i) => (i > 0 ? borderStyle({ ...lineStyle(i - 1), ...curves[i - 1].style }.dash) : "solid") } },
      // Without a pointer over the plot its legend reads the place that is marked.
      hooks: { draw: [(u) => this.#drawMarks(u)], setLegend: [(u) => u.legend.idx == null && this.#readMark(u)], ready: [(u) => this.#readMark(u)] },
    };
  }

  #seek(chart, event, next) {
    const left = event.clientX - chart.over.getBoundingClientRect().left;
    this.#options.onSeek?.(chart.posToVal(left, "x"));
    return next(event);
  }

  /** Marks a place, as the time that is shown elsewhere on the page; the legend reads the values there. */
  mark(x) {
    this.#marked = x;
    if (!this.#chart) return;
    this.#chart.redraw(false);
    this.#readMark(this.#chart);
  }

  #readMark(chart) {
    if (this.#marked != null) chart.setLegend({ idx: chart.valToIdx(this.#marked) }, false);
  }

  #drawMarks(chart) {
    const { ctx, bbox } = chart;
    ctx.save();
    ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
    this.#drawLevels(chart);
    ctx.setLineDash([]);
    if (this.#marked != null) {
      const at = chart.valToPos(this.#marked, "x", true);
      line(ctx, "#12344d", at, bbox.top, at, bbox.top + bbox.height);
    }
    ctx.restore();
  }

  /** The levels as lines, then their labels, each where it covers no other one. */
  #drawLevels({ ctx, bbox, valToPos }) {
    const all = (this.#options.levels ?? []).map(({ value, label }) => ({ label, at: valToPos(value, "y", true) }));
    const shown = all.filter(({ at }) => at >= bbox.top && at <= bbox.top + bbox.height);
    const ends = [bbox.left, bbox.left + bbox.width];
    // Room for labels is in pixels of the page, as their font.
    const [left, right, top, bottom] = [...ends, bbox.top, bbox.top + bbox.height].map((place) => place / devicePixelRatio);
    const places = new LabelPlaces({ left, right, top, bottom });
    for (const { at } of shown) {
      line(ctx, "#7a8794", ends[0], at, ends[1], at);
      places.keepLine([[left, at / devicePixelRatio], [right, at / devicePixelRatio]]);
    }
    ctx.setLineDash([]);
    for (const { label, at } of shown) {
      const { x, y, isEnd } = places.alongLine(label, at / devicePixelRatio, true);
      ctx.textAlign = isEnd ? "right" : "left";
      const place = [x * devicePixelRatio, y * devicePixelRatio];
      // Words that no line strikes through.
      [ctx.strokeStyle, ctx.lineWidth, ctx.fillStyle] = ["#fff", 3 * devicePixelRatio, "#4a5866"];
      ctx.strokeText(label, ...place);
      ctx.fillText(label, ...place);
    }
    ctx.lineWidth = devicePixelRatio;
  }

  /** The values as comma-separated text, with units in the names of the columns. */
  csv() {
    const { x, y, curves } = this.#options;
    const named = (label, unit) => (unit ? `${label} [${unit}]` : label);
    const head = [named(x.label, x.unit), ...curves.map((c) => named(c.label, y.unit))];
    return commaSeparated([head, ...x.values.map((at, i) => [at, ...curves.map((c) => c.values[i])])]);
  }

  /** Fills the table, while it is open. */
  #fillTable() {
    if (!this.#rows.open) return;
    const { title, x, y, curves } = this.#options;
    const every = Math.max(1, Math.ceil(x.values.length / MOST_ROWS));
    const rows = [];
    for (let i = 0; i < x.values.length; i += every) {
      rows.push([number(x.values[i]), ...curves.map((c) => number(c.values[i]))]);
    }
    const caption = every > 1 ? `${title}: one value in ${every}; the CSV has all` : title;
    const columns = [`${x.label} [${x.unit}]`, ...curves.map((c) => (y.unit ? `${c.label} [${y.unit}]` : c.label))];
    this.#rows.replaceChildren(this.#rows.firstChild, table(caption, columns, rows));
  }

  /** The curves with title and legend, on white. */
  #savePicture() {
    const source = this.#chart.ctx.canvas;
    const scale = source.width / this.holder.clientWidth;
    const canvas = html("canvas", { width: source.width, height: source.height + 48 * scale });
    const context = canvas.getContext("2d");
    context.fillStyle = "#fff";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(source, 0, 24 * scale);
    context.scale(scale, scale);
    context.fillStyle = "#12344d";
    context.font = "bold 13px system-ui, sans-serif";
    context.fillText(this.#options.title, 10, 17);
    context.font = "12px system-ui, sans-serif";
    let at = 10;
    this.#options.curves.forEach((curve, i) => {
      const { stroke, dash } = { ...lineStyle(i), ...curve.style };
      const baseline = canvas.height / scale - 9;
      context.setLineDash(dash);
      context.lineWidth = 2;
      line(context, stroke, at, baseline - 4, at + 26, baseline - 4);
      context.fillStyle = "#12344d";
      context.fillText(curve.label, at + 31, baseline);
      at += 46 + context.measureText(curve.label).width;
    });
    canvas.toBlob((blob) => saveFile(`${this.#fileName()}.png`, blob));
  }

  dispose() {
    this.#watcher.disconnect();
    this.#chart?.destroy();
  }
}

/** The nearest style of borders, for the marker in the legend. */
function borderStyle(dash) {
  if (!dash.length) return "solid";
  return dash[0] > 4 ? "dashed" : "dotted";
}

/** The value at a place of a curve that has gaps, or the nearest one of those around the gap; null before the first and after the last. */
function valueNear(values, at) {
  const [before, after] = [values.findLastIndex((value, i) => i <= at && value != null), values.findIndex((value, i) => i >= at && value != null)];
  if (before < 0 || after < 0) return null;
  return values[at - before < after - at ? before : after];
}

/** A number at an axis, without zeros behind the point. */
function plainTick(tick) {
  return number(tick, 4).replace(/\.0+(?!\d)|(\.\d*?[1-9])0+(?!\d)/, "$1");
}

/** Room for the labels of an axis [px]; there are none before the first drawing. */
function widthOf(labels) {
  return Math.max(58, 22 + 7 * Math.max(0, ...(labels ?? []).map((label) => label.length)));
}

function line(context, colour, x0, y0, x1, y1) {
  context.strokeStyle = colour;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
