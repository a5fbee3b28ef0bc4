// The two runs of a comparison: numbers at once, recordings by need.

import { getJson } from "../api.js";
import { forceWindow } from "../picture/view_settings.js";
import { Recording } from "../recording/recording.js";
import { mainImpact, resultsOf } from "../summary/headline.js";

/** A run {label, job, summary, window, contact, shift} with its `opening` recording, which is read later. */
export async function loadRun(label, id) {
  const job = await getJson(`/v1/jobs/${id}`);
  if (!job.links.summary || !job.links.recording) throw new Error(`${job.name} has no recording with numbers, so there is nothing to compare.`);
  const opening = Recording.open(job.links.recording);
  // What goes wrong there is said where it is waited for.
  opening.catch(() => {});
  const summary = await getJson(job.links.summary);
  return { label, job, summary, opening, recording: null, window: forceWindow(summary), contact: contactOf(summary), shift: 0 };
}

/** Simulated time at which a run's contact with the tissue begins [s], by its summary; null where that does not say. */
function contactOf(summary) {
  return mainImpact(resultsOf(summary))?.contact_span_s?.[0] ?? null;
}

/** The same by the frames of a whole recording. */
export function firstTouch({ frames }) {
  return frames.find((frame) => frame.contacts?.some(({ node }) => node.length))?.time ?? null;
}

/** Bodies of both whose nodes can be compared one by one. */
export function commonBodies([a, b]) {
  const names = [...a.recording.bodies.values()].filter(({ name, cells }) => {
    const other = b.recording.bodies.get(name);
    return cells && other?.cells && cells.equals(other.cells);
  });
  return new Set(names.map(({ name }) => name));
}

/**
 * Reads the recordings of runs: `onFirst()` once, when each has the frame nearest to `first` [s] or has none, then `onProgress(fraction)`
 * of the one that has come least far. The rest of a recording waits for the pictures of all.
 */
export async function readAll(runs, first, { onFirst, onProgress }) {
  const fractions = runs.map(() => 0);
  let [missing, shown] = [runs.length, null];
  const all = new Promise((resolve) => (shown = resolve));
  const arrived = () => {
    missing -= 1;
    if (missing === 0) shown(onFirst());
    return all;
  };
  await Promise.all(runs.map(async ({ recording }, i) => {
    let isFirst = true;
    const arrive = () => (isFirst ? ((isFirst = false), arrived()) : all);
    const note = (fraction) => {
      fractions[i] = fraction;
      onProgress(Math.min(...fractions));
    };
    await recording.read({ first, onFirst: arrive, onProgress: note });
    await arrive();
  }));
}
