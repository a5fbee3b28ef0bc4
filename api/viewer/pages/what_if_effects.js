// What matters most: how far each parameter by itself moves each number from its low to its high end.

import { html, table } from "../dom.js";
import { change, number, within } from "../format.js";

/**
 * The effects as a table, the largest first. An effect is the largest minus the smallest of the numbers at the low end, in the base
 * and at the high end: what rises and falls again has one too. `numbers` are [key, title], `base` the numbers of the base with their
 * errors, `describe(name)` a parameter.
 */
export function effectsTable(sensitivities, numbers, base, describe) {
  const order = numbers.map(([key]) => key);
  const shown = sensitivities.filter((s) => order.includes(s.quantity)).map((s) => ({ ...s, effect: effectOf(s) }));
  shown.sort((a, b) => order.indexOf(a.quantity) - order.indexOf(b.quantity) || b.effect - a.effect);
  const rows = shown.map((s) => {
    const { label, unit, factor } = describe(s.parameter);
    const error = base?.[s.quantity]?.error;
    const [low, , high] = s.parameter_values.map((value) => number(value * factor, 3));
    return [
      numbers[order.indexOf(s.quantity)][1],
      label.split(",")[0],
      `${low} → ${high} ${unit === "-" ? "" : unit}`.trim(),
      change(s.effect, largest(s), error).replace("+", ""),
      html("span", {}, s.values.map((value) => within(value, error)).join(" → "), " ", s.is_monotone ? "" : html("span", { class: "badge" }, "not monotone")),
      s.elasticity == null || !s.is_monotone ? "–" : number(s.elasticity, 2),
      verdict(s, error),
    ];
  });
  const columns = ["number", "parameter", "low → high", "effect: largest − smallest", "at the low end → base → high end", "elasticity", "numerical error"];
  return html("section", { class: "what-matters" }, html("h2", {}, "What matters most"), table("Effect of each parameter alone on each number, from low to high, largest first", columns, rows));
}

const effectOf = ({ values }) => Math.max(...values) - Math.min(...values);
const largest = ({ values }) => Math.max(...values.map(Math.abs));

function verdict({ effect }, error) {
  if (error == null) return html("span", { class: "badge" }, "error unknown");
  return html("span", { class: effect > error ? "badge good" : "badge warn" }, effect > error ? "beyond its error" : "within its error");
}
