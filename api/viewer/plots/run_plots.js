// The plots of runs over time: force, impulse, energy. One run, or several for comparison.

import { timeUnit, timeWords } from "../format.js";
import { mainPair } from "./main_pair.js";
import { Plot } from "./plot.js";

/** Values on a common axis: those of `values` at `times`, in the order of `axis`, null elsewhere. */
function onAxis(axis, times, values) {
  const at = new Map(times.map((time, i) => [time, values[i]]));
  return axis.map((time) => at.get(time) ?? null);
}

/** Recorded times of a run [s], from its `shift` on. */
const timesOfForces = ({ recording, shift = 0 }) => recording.series.forceTimes.map((time) => time - shift);
const timesOfEnergies = ({ recording, shift = 0 }) => recording.series.energyTimes.map((time) => time - shift);

/** The last of some times, in the unit of a plot. */
const endOf = (times, unit) => times.at(-1) * unit.factor;

/** Force and impulse of the runs' main pairs, [{label, recording, window, shift}], as plots. */
export function contactPlots(runs, shared) {
  const withContact = runs.filter(({ recording }) => mainPair(recording) && recording.series.forceTimes.length > 1);
  if (!withContact.length) return [];
  const unit = timeUnit(Math.max(...runs.map(({ recording }) => recording.endTime)));
  const axis = [...new Set(withContact.flatMap(timesOfForces))].sort((a, b) => a - b);
  const x = () => ({ label: shared.time ?? "time", unit: unit.name, values: axis.map((t) => t * unit.factor) });
  const curve = ({ label, ...run }, words, values, more) => ({
    label: runs.length > 1 ? `${label}: ${words}` : words,
    values: onAxis(axis, timesOfForces(run), values),
    end: endOf(timesOfForces(run), unit),
    style: { spanGaps: true, ...more?.style },
    width: more?.width,
  });
  const columns = ({ recording }) => recording.series.pairs.get(mainPair(recording));
  // Without a summary yet: a tenth of the time so far, as the summary averages over a tenth of the contact.
  const window = ({ window: chosen, recording }) => chosen || (recording.series.forceTimes.at(-1) || 1) / 10;
  const force = {
    ...shared,
    title: "Contact force",
    note: runs.length > 1 ? "" : withContact.map(({ recording }) => mainPair(recording)).join(", "),
    y: { label: "force", unit: "N" },
    x: x(),
    curves: withContact.flatMap((run) => {
      const mean = curve(run, `mean over ${timeWords(window(run))}`, run.recording.series.meanForce(mainPair(run.recording), window(run)), { width: 2.5 });
      if (runs.length > 1) return [mean];
      return [mean, curve(run, "each step", columns(run).force, { width: 1, style: { stroke: "#9aa7b4", dash: [3, 3] } })];
    }),
  };
  const impulse = {
    ...shared,
    title: "Impulse",
    y: { label: "impulse", unit: "N s" },
    x: x(),
    curves: withContact.map((run) => curve(run, "impulse so far", columns(run).impulseNorm)),
  };
  const area = {
    ...shared,
    title: "Contact area",
    y: { label: "area", unit: "mm²" },
    x: x(),
    curves: withContact.map((run) => curve(run, "touching area", columns(run).area.map((a) => a * 1e6))),
  };
  return [force, impulse, area].map((options) => new Plot(options));
}

const TERMS = [
  ["kinetic", "kinetic"],
  ["strain", "strain"],
  ["dissipated", "dissipated"],
  ["absorbed", "absorbed by the tissue"],
  ["sum", "sum: kinetic + strain + dissipated"],
  ["supplied", "supplied: at the start + external work"],
];

/** The energies of one run, with their sum; of several runs what the tissue absorbs. */
export function energyPlot(runs, shared) {
  const unit = timeUnit(Math.max(...runs.map(({ recording }) => recording.endTime)));
  const axis = [...new Set(runs.flatMap(timesOfEnergies))].sort((a, b) => a - b);
  const x = { label: shared.time ?? "time", unit: unit.name, values: axis.map((t) => t * unit.factor) };
  const common = { ...shared, y: { label: "energy", unit: "J" }, x };
  if (runs.length > 1) {
    const curves = runs.map(({ label, ...run }) => ({
      label: `${label}: absorbed by the tissue`,
      values: onAxis(axis, timesOfEnergies(run), run.recording.series.energy.absorbed),
      end: endOf(timesOfEnergies(run), unit),
      style: { spanGaps: true },
    }));
    return new Plot({ ...common, title: "Absorbed energy", curves });
  }
  const [{ recording }] = runs;
  const curves = TERMS.map(([name, label]) => ({
    label,
    values: recording.series.energy[name],
    ...(name === "sum" && { width: 3 }),
    ...(name === "supplied" && { width: 1.5, style: { stroke: "#56b4e9", dash: [3, 4] } }),
  }));
  return new Plot({ ...common, title: "Energy", note: "the sum stays at what was supplied", curves });
}
