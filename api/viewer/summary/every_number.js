// Every number of a summary in one table.

import { table } from "../dom.js";
import { number } from "../format.js";
import { resultsOf } from "./headline.js";
import { digits, hasError } from "./quantity.js";

/** What the error of a number is made of. */
const ERROR_PARTS = ["mesh", "step", "contact", "bulk_modulus", "resolution"];

/** Every number of the summary as a table. */
export function allNumbers(summary) {
  const [rows, results] = [[], resultsOf(summary)];
  const walk = (path, value) => {
    if (value && typeof value === "object" && "value" in value && "error" in value) {
      const words = path.join(" › ").replaceAll("_", " ");
      const parts = hasError(value) ? ["total", ...ERROR_PARTS].map((k) => number(value.error[k] ?? 0, 2)) : [value.error, ...ERROR_PARTS.map(() => "")];
      rows.push([words, summary.withheld ? "withheld" : value.error === "nothing touched" ? "–" : digits(value), ...parts]);
    } else if (value && typeof value === "object") {
      for (const [key, inner] of Object.entries(value)) {
        const name = Array.isArray(value) ? inner?.pair ?? inner?.part ?? (inner?.threshold_pa ? `${inner.threshold_pa / 1e3} kPa` : key) : key;
        walk([...path, name], inner);
      }
    }
  };
  walk([], results);
  return table("Every number, with the parts of its error; in brackets what is not resolved, or has no error; ≥ a lower bound; units are the ends of the names", ["number", "value", "± error", ...ERROR_PARTS], rows);
}
