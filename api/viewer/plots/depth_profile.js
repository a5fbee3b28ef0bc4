// The field below the surface: along the line of the impact, straight in from where the contact force is centred, layer by layer.

import { valuesAlong } from "../mesh/along_line.js";
import { Layers } from "./layers.js";
import { Plot, lineStyle } from "./plot.js";

/** Deeper is not shown [m]. */
const DEEPEST = 0.06;
/** Crossings nearer than this are one place [m]: each face is seen from both sides. */
const SAME_PLACE = 1e-7;

export class DepthProfile {
  #plot;
  #body;
  #line;
  #layers;

  constructor(name, body, line, field, top, levels) {
    this.#body = body;
    this.#line = line;
    this.#layers = new Layers(body, field);
    const note = this.#layers.curves.some((curve) => curve.isMixed) ? "; dashed: averaged across layers" : "";
    this.#plot = new Plot({
      name,
      title: "Depth profile",
      note: `straight in from the impact, in the tissue as it is deformed${note}`,
      x: { label: "depth straight in", unit: "mm", values: [0] },
      y: { label: field.label.split(" (")[0], unit: field.unit },
      curves: this.#layers.curves.map(({ label, part, isMixed }) => ({ label, values: [null], style: { ...lineStyle(part), dash: isMixed ? [5, 4] : [] } })),
      levels,
      range: (_, low, high) => [Math.min(low ?? 0, 0), Math.max(high ?? 0, top * 1.05)],
    });
    this.element = this.#plot.element;
    this.factor = field.factor;
  }

  show(state, values) {
    const { centre, direction } = this.#line;
    // From well outside, so that a surface that bulges is met.
    const origin = centre.map((c, k) => c - direction[k] * DEEPEST);
    const hits = valuesAlong({ cells: this.#body.cells, positions: state.positions, values, origin, direction, eroded: state.eroded });
    const depths = [];
    const columns = this.#layers.curves.map(() => []);
    for (const { s, value, element } of hits) {
      const depth = (s - hits[0].s) * 1e3;
      if (depth > DEEPEST * 1e3) break;
      if (!depths.length || depth - depths.at(-1) > SAME_PLACE * 1e3) {
        depths.push(depth);
        columns.forEach((column) => column.push(null));
      }
      columns[this.#layers.curveOf(element)][depths.length - 1] = value * this.factor;
    }
    this.#plot.setData(depths.length ? depths : [0], depths.length ? columns : columns.map(() => [null]));
    this.#plot.mark(depths[placeOfLargest(columns)] ?? null);
  }

  dispose() {
    this.#plot.dispose();
  }
}

/** Where the largest value of some columns stands; -1 where there is none. */
function placeOfLargest(columns) {
  const tops = (columns[0] ?? []).map((_, i) => Math.max(...columns.map((column) => column[i] ?? -Infinity)));
  return tops.indexOf(Math.max(...tops));
}
