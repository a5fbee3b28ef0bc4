// What to know before the numbers are used: the most severe in one line, with a link to all.

import { html } from "../dom.js";
import { inWords } from "../scene/scene_units.js";
import { plainly } from "./plain_terms.js";
import { reason } from "./trust.js";

/** All that is to be known, the worst first: {kind: "bad" | "warn", words, isMeshed?}; `isMeshed` where other meshes help. */
export function concerns(summary) {
  return allConcerns(summary).map((one) => ({ ...one, words: inWords(one.words) }));
}

function allConcerns(summary) {
  const found = [];
  const why = reason(summary);
  if (why) found.push({ kind: "bad", words: why });
  const failed = why ? [] : summary.gates.filter((gate) => gate.result !== "passed");
  failed.forEach((gate) => found.push({ kind: "bad", words: `A check of the computation failed: ${gate.meaning}.` }));
  // The program lists the most severe first.
  return [...found, ...summary.warnings.map((words) => ({ kind: "warn", words, isMeshed: /^The (mesh|numerical error of the main numbers) /.test(words) }))];
}

/** The first part of a warning: what is so, without its numbers and remedies. */
function short({ words }) {
  const [first] = words.split(/: (?=[a-z])|; (?=[a-z])/);
  return /[.!]$/.test(first) ? first : `${first}.`;
}

/** The worst in one line; `onOpen` leads to all. `remedy`, an element, comes behind it. */
export function warningLine(summary, onOpen, remedy = null) {
  const all = concerns(summary);
  const open = html("button", { type: "button", onclick: onOpen }, all.length > 1 ? `All ${all.length}` : "Can these numbers be trusted?");
  if (!all.length) return html("div", { class: "warning-line good" }, html("span", {}, "All checks of the computation passed; no warnings."), open);
  const [worst] = all;
  const badge = html("span", { class: `badge ${worst.kind}` }, worst.kind === "bad" ? "✗ no result" : "warning");
  return html("div", { class: `warning-line ${worst.kind}` }, html("span", {}, badge, " ", plainly(worst.kind === "bad" ? worst.words : short(worst))), html("span", { class: "tools" }, remedy, open));
}
