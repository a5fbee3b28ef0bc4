// The range of the colours: from the data and the thresholds, as the recording or the reader has it, or logarithmic.

import { FIELDS } from "../mesh/colours.js";

/** Of each frame this fraction of the nodes may lie beyond the top of a range that fits: peaks at a point [-]. */
const BEYOND = 0.002;
/** Values of a frame that are looked at, at most. */
const MOST_VALUES = 20_000;
/** A logarithmic range begins at this fraction of the lowest threshold, or of its top where there is none [-]. */
const [BELOW_THRESHOLD, BELOW_TOP] = [0.1, 1e-3];
/** A range over more than this ratio of top and lowest threshold is logarithmic at first [-]. */
const WIDE = 20;

export const MODES = [["fit", "fits this run"], ["log", "logarithmic"], ["fixed", "fixed"]];

/** A number rounded up to two digits. */
function roundUp(value) {
  if (!(value > 0)) return 1;
  const step = 10 ** (Math.floor(Math.log10(value)) - 1);
  return Math.ceil(value / step - 1e-9) * step;
}

/** What nearly all nodes of the tissue stay below in every frame. */
function top(recording, field) {
  const values = recording.frames.map((frame) => frame.bodies.get(recording.tissue?.name)?.fields?.[field]);
  return Math.max(0, ...values.filter(Boolean).map(topOf));
}

/** By the values of a frame. */
const tops = new WeakMap();

/** What nearly all values are below. */
function topOf(values) {
  if (!tops.has(values)) {
    const every = Math.max(1, Math.floor(values.length / MOST_VALUES));
    const some = new Float32Array(Math.floor(values.length / every));
    for (let i = 0; i < some.length; i++) some[i] = Math.abs(values[i * every]);
    tops.set(values, some.sort()[Math.min(some.length - 1, Math.floor((1 - BEYOND) * some.length))] ?? 0);
  }
  return tops.get(values);
}

/** The range of a field in a mode, for all these recordings; `levels` are its thresholds. */
export function rangeOf(recordings, field, mode, levels) {
  const { from } = FIELDS[field];
  const stress = (recording) => JSON.parse(recording.run.colour_range_pa ?? "[0, 0]")[1];
  const isStress = field === "von_mises_pa" || field === "pressure_pa";
  const fitted = roundUp(Math.max(...recordings.map((r) => top(r, field)), levels[0] ?? 0));
  if (mode === "log") return [(levels[0] ?? fitted) * (levels.length ? BELOW_THRESHOLD : BELOW_TOP), Math.max(fitted, levels[0] ?? 0)];
  const fixed = isStress ? Math.max(...recordings.map(stress)) : 0;
  const most = mode === "fixed" && fixed > 0 ? fixed : fitted;
  return [from * most, most];
}

/** The mode in which a field is shown at first. */
export function firstMode(recordings, field, levels) {
  const { from } = FIELDS[field];
  const fitted = Math.max(...recordings.map((r) => top(r, field)));
  return from === 0 && levels.length && fitted > WIDE * levels[0] ? "log" : "fit";
}
