// The field below the skin: along the line of the impact, straight in from where the contact force is centred.

import { valuesAlong } from "../mesh/hexahedra.js";
import { flatPatch } from "./patch.js";
import { Plot } from "./plot.js";

/** Deeper is not shown [m]. */
const DEEPEST = 0.06;

/** The line of the impact: through the centre of the first contacts that were recorded, into the tissue; null without contact. */
export function impactLine(recording) {
  const tissue = recording.tissue;
  for (const frame of recording.frames) {
    const pairs = (frame.contacts ?? []).map(flatPatch).filter(Boolean);
    if (!pairs.length || !tissue) continue;
    const [{ centre, normal }] = pairs;
    // Inwards is where the tissue is.
    const count = tissue.X.length / 3;
    const middle = [0, 1, 2].map((k) => tissue.X.reduce((sum, c, i) => (i % 3 === k ? sum + c : sum), 0) / count);
    const side = normal.reduce((sum, n, k) => sum + n * (middle[k] - centre[k]), 0);
    return { centre, direction: normal.map((n) => (side < 0 ? -n : n)) };
  }
  return null;
}

export class DepthProfile {
  #plot;
  #body;
  #line;

  constructor(name, body, line, field, top, levels) {
    this.#body = body;
    this.#line = line;
    this.#plot = new Plot({
      name,
      title: "Depth profile",
      note: "straight in, below the impact",
      x: { label: "depth below the skin", unit: "mm", values: [0] },
      y: { label: field.label.split(" (")[0], unit: field.unit },
      curves: [{ label: field.label.split(" (")[0], values: [0] }],
      levels,
      range: (_, low, high) => [Math.min(low ?? 0, 0), Math.max(high ?? 0, top * 1.05)],
    });
    this.element = this.#plot.element;
    this.factor = field.factor;
  }

  show(state, values) {
    const { centre, direction } = this.#line;
    // From well outside, so that a skin that bulges is met.
    const origin = centre.map((c, k) => c - direction[k] * DEEPEST);
    const hits = valuesAlong({ hexes: this.#body.hexes, positions: state.positions, values, origin, direction });
    const first = hits[0]?.s ?? 0;
    const shown = hits.filter((hit) => hit.s - first <= DEEPEST);
    const depths = shown.map((hit) => (hit.s - first) * 1e3);
    this.#plot.setData(depths.length ? depths : [0], [depths.length ? shown.map((hit) => hit.value * this.factor) : [null]]);
  }

  dispose() {
    this.#plot.dispose();
  }
}
