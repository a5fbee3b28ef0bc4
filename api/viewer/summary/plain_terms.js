// Terms of engineers in texts of the program in plain words, with the term itself and what it is as an explanation.

import { term } from "../dom.js";
import { ABOUT_STRESS } from "./layers.js";

/** [pattern, plain words, explanation]; of patterns that fit one place the first counts. */
const TERMS = [
  ["`?(?:contuse run )?--lower-bulk-modulus`?", "an accuracy with lower stiffness against compression", "“lower stiffness against compression” (lower_bulk_modulus) of the required accuracy of a scene; --lower-bulk-modulus on the command line"],
  ["K/G", "the ratio of stiffness against compression to that in shear", "K/G: bulk modulus over shear modulus"],
  ["bulk mod(?:ulus|uli)", "stiffness against compression", "bulk modulus, K: the pressure that a change of volume takes"],
  ["held nodes", "fixed surface", "held nodes: points of the mesh that cannot move, as where tissue is attached to bone"],
  ["von Mises stress", "stress", ABOUT_STRESS],
  ["speed of pressure waves", "speed of sound", "pressure waves in the tissue as it is modelled"],
];
const ALL = new RegExp(TERMS.map(([pattern]) => `(${pattern})`).join("|"), "gi");

/** A text as words and terms; a term is explained where it is first met. */
export function plainly(text) {
  const met = new Set();
  const parts = [];
  let from = 0;
  for (const match of text.matchAll(ALL)) {
    const which = match.slice(1).findIndex((found) => found !== undefined);
    const [, plain, about] = TERMS[which];
    // As the term begins a sentence, so do the plain words.
    const isFirst = /^[A-Z][a-z]/.test(match[0]);
    const words = isFirst ? plain[0].toUpperCase() + plain.slice(1) : plain;
    parts.push(text.slice(from, match.index), met.has(which) ? words : term(words, about));
    met.add(which);
    from = match.index + match[0].length;
  }
  return [...parts, text.slice(from)];
}
