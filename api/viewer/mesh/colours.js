// Colours of values: maps that are even to the eye and to the colour-blind, and the fields that are shown with them.

import { html, term } from "../dom.js";
import { number, setting } from "../format.js";

/** Seventeen equally spaced colours each: cividis of matplotlib for values, and a blue–white–orange for differences. */
const STOPS = {
  values:
    "00224e002e6a1a386f32436d434e6c535a6d61656f6f70737d7c788c88789b9476aba072bcae6ccdbb63dec958f0d846fee838",
  difference:
    "0b3d6b17508228659a3f7bb05b93c37aabd49dc3e2c3dcedf4f4f2f6dfc4f2c79aeaae72de944ecb7a32b2621d944c0f74380a",
};

/** Fields that are shown. Those that are means live in elements: at a node they are averaged over the elements around it, across layers too. */
export const FIELDS = {
  von_mises_pa: { label: "stress", about: "von Mises stress: how strongly the tissue is sheared, as one number", unit: "kPa", factor: 1e-3, from: 0, isMean: true },
  pressure_pa: { label: "pressure", about: "mean of the three normal stresses, positive in compression", unit: "kPa", factor: 1e-3, from: -1, isMean: true },
  principal_strain: { label: "stretch (principal strain)", about: "largest principal Green–Lagrange strain: 0.5 is a stretch to 1.41 of the length", unit: "", factor: 1, from: 0, isMean: true },
  displacement_m: { label: "displacement", about: "distance from where the undeformed body would be", unit: "mm", factor: 1e3, from: 0 },
  velocity_m_per_s: { label: "speed", about: "of the material", unit: "m/s", factor: 1, from: 0 },
};

/** 256 colours of a map, that of "values" or of a "difference", as bytes r, g, b, a. */
export function lookupTable(map) {
  const stops = STOPS[map].match(/../g).map((two) => parseInt(two, 16));
  const table = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * 16;
    const left = Math.min(Math.floor(at), 15);
    for (let k = 0; k < 3; k++) {
      const [a, b] = [stops[3 * left + k], stops[3 * left + 3 + k]];
      table[4 * i + k] = Math.round(a + (at - left) * (b - a));
    }
    table[4 * i + 3] = 255;
  }
  return table;
}

/** A value at a fraction of a range. */
function valueAt(fraction, [low, high], isLog) {
  return isLog ? low * (high / low) ** fraction : low + fraction * (high - low);
}

/** Where a value stands in a range, from 0 to 1. */
function fractionOf(value, [low, high], isLog) {
  return isLog ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
}

/** Least distance of the names of two thresholds from each other, in widths of the legend [-]. */
const APART = 0.09;
/** No name is nearer to the ends than this [-]. */
const EDGE = 0.03;

/** The names of the `levels` that are in the range, each above its line, or beside the one before where they are close. */
function levelNames(levels, range, isLog, { factor, unit }) {
  const shown = levels.map((level) => ({ level, at: fractionOf(level, range, isLog) })).filter(({ at }) => at > 0 && at < 1);
  let last = -Infinity;
  return html("ol", { class: "levels" }, shown.map(({ level, at }, i) => {
    last = Math.min(Math.max(at, EDGE, last + APART), 1 - 2 * EDGE);
    const name = html("li", {}, setting(level * factor) + (i === shown.length - 1 ? ` ${unit}` : ""));
    name.style.left = `${(100 * last).toFixed(1)}%`;
    return name;
  }));
}

/** A legend: the map over the range, with ticks, the unit, and named marks at thresholds. */
export class Legend {
  element = html("figure", { class: "legend" });

  show({ label, about = "", unit, factor, isMean }, range, map, { isLog = false, levels = [] } = {}) {
    const names = levelNames(levels, range, isLog, { unit, factor });
    const bar = html("canvas", { width: 256, height: 1, "aria-hidden": "true" });
    const context = bar.getContext("2d");
    const image = context.createImageData(256, 1);
    image.data.set(lookupTable(map));
    for (const level of levels) {
      const at = Math.round(255 * fractionOf(level, range, isLog));
      if (at > 0 && at < 255) image.data.set([0, 0, 0, 255], 4 * at);
    }
    context.putImageData(image, 0, 0);
    const ticks = [0, 0.25, 0.5, 0.75, 1].map((fraction) => html("li", {}, number(valueAt(fraction, range, isLog) * factor, isLog ? 2 : 3)));
    const note = [about, isMean && "at a node the mean of the elements around it, across layers too", "beyond the range the end colour"].filter(Boolean).join("; ");
    this.element.replaceChildren(
      html("figcaption", {}, term(label, note), unit ? ` [${unit}]` : " [–]", html("small", {}, ` ${[isLog && "logarithmic", names.children.length && "black lines: thresholds"].filter(Boolean).join("; ")}`)),
      names.children.length ? names : "",
      bar,
      html("ol", {}, ticks),
    );
  }
}
