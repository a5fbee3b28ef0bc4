// The contact pair that a page speaks of.

import { mainImpact, resultsOf } from "../summary/headline.js";

/** Whether a pair, "ball–thigh", is of a body and another one. */
export function isOn(name, pair) {
  return pair.startsWith(`${name}–`) !== pair.endsWith(`–${name}`);
}

/** The pair of the summary's main impact; without one yet that of the largest force so far, of those on the tissue if there are any. */
export function mainPair({ series, tissue, latestSummary }) {
  const said = latestSummary && mainImpact(resultsOf(latestSummary))?.pair;
  if (series.pairs.has(said)) return said;
  const pairs = [...series.pairs].map(([name, { force }]) => ({ name, peak: force.reduce((most, f) => Math.max(most, f), 0) }));
  const onTissue = pairs.filter(({ name }) => tissue && isOn(tissue.name, name));
  const candidates = onTissue.length ? onTissue : pairs;
  return candidates.reduce((best, pair) => (!best || pair.peak > best.peak ? pair : best), null)?.name;
}
