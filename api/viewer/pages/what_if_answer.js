// The answer to a what-if question: a table of cases that fills as they come, and what each parameter does by itself.

import { html, saveFile, button, table } from "../dom.js";
import { number } from "../format.js";

/** The four numbers, by their names on the wire. */
const NUMBERS = [
  ["peak_force_n", "peak force [N]"],
  ["patch_area_mm2", "contact patch [mm²]"],
  ["stress_depth_mm", "depth of stress [mm]"],
  ["absorbed_energy_j", "absorbed energy [J]"],
];

/** A number with its error; in brackets when the error is larger. */
function words(quantity) {
  if (!quantity) return "–";
  const { value, error } = quantity;
  if (error == null) return number(value);
  return `${error > Math.abs(value) ? `(${number(value)})` : number(value)} ± ${number(error, 2)}`;
}

export class WhatIfAnswer {
  element = html("div");
  #known;
  #cases = new Map();
  #sensitivities = html("div");
  #count = 0;

  /** `known` describes parameters by name: {label, unit, factor, base}; what is not known is shown as it is. */
  constructor(known = new Map()) {
    this.#known = known;
    this.#show();
  }

  /** Takes in an event of the job. */
  take({ event, data }) {
    if (event === "case") {
      this.#cases.set(data.index, data);
      this.#count = data.of;
      this.#show();
    }
  }

  /** Takes in the whole answer. */
  takeAll(answer) {
    for (const parameter of answer.parameters) {
      if (!this.#known.has(parameter.name)) this.#known.set(parameter.name, { label: parameter.name, unit: parameter.unit, factor: 1 });
    }
    answer.cases.forEach((one) => this.#cases.set(one.index, one));
    this.#count = answer.cases.length;
    if (answer.sensitivities.length) this.#sensitivities.replaceChildren(this.#sensitivityTable(answer.sensitivities));
    this.errorBars = answer.error_bars;
    this.#show();
  }

  #describe(name) {
    return this.#known.get(name) ?? { label: name, unit: "", factor: 1 };
  }

  #show() {
    const cases = [...this.#cases.values()].sort((a, b) => a.index - b.index);
    if (!cases.length) return this.element.replaceChildren(html("p", { class: "quiet" }, "No case yet."));
    const base = cases[0]?.parameters ?? {};
    const names = Object.keys(base);
    const heads = names.map((name) => {
      const { label, unit } = this.#describe(name);
      return `${label.split(",")[0]}${unit ? ` [${unit}]` : ""}`;
    });
    const rows = cases.map((one) => {
      const values = names.map((name) => {
        const text = number(one.parameters[name] * this.#describe(name).factor, 3);
        return one.parameters[name] === base[name] ? html("span", { class: "quiet" }, text) : html("b", {}, text);
      });
      const numbers = NUMBERS.map(([key]) => (one.ending === "finished" ? words(one.numbers[key]) : ""));
      if (one.ending !== "finished") numbers[0] = `${one.ending}: ${one.reason ?? ""}`;
      return [one.index === 0 ? "as it was" : one.name, ...values, ...numbers];
    });
    const caption = cases.length < this.#count ? `${cases.length} of ${this.#count} cases` : `${cases.length} cases; what differs from the base is bold`;
    this.element.replaceChildren(
      table(caption, ["case", ...heads, ...NUMBERS.map(([, title]) => title)], rows),
      this.errorBars ? html("p", { class: "quiet" }, `Errors: ${this.errorBars}.`) : "",
      button("CSV", () => this.#saveCsv(cases, names), { "aria-label": "Cases as CSV" }),
      this.#sensitivities,
    );
  }

  #saveCsv(cases, names) {
    const quoted = (text) => `"${String(text).replaceAll('"', '""')}"`;
    const head = ["case", "ending", ...names, ...NUMBERS.flatMap(([key]) => [key, `${key}_error`])];
    const rows = cases.map((one) => [
      quoted(one.name), one.ending, ...names.map((name) => one.parameters[name]),
      ...NUMBERS.flatMap(([key]) => [one.numbers[key]?.value ?? "", one.numbers[key]?.error ?? ""]),
    ]);
    saveFile("what-if.csv", `${[head.map(quoted), ...rows].map((row) => row.join(",")).join("\n")}\n`, "text/csv");
  }

  /** What each parameter changes over its range, the strongest first. */
  #sensitivityTable(sensitivities) {
    const shown = sensitivities.filter((s) => NUMBERS.some(([key]) => key === s.quantity));
    shown.sort((a, b) => NUMBERS.findIndex(([k]) => k === a.quantity) - NUMBERS.findIndex(([k]) => k === b.quantity) || a.rank - b.rank);
    const rows = shown.map((s) => {
      const { label, unit, factor } = this.#describe(s.parameter);
      const [low, , high] = s.parameter_values.map((value) => number(value * factor, 3));
      const verdict = s.exceeds_numerical_error == null ? "–" : s.exceeds_numerical_error ? "beyond its error" : "within its error";
      return [
        NUMBERS.find(([key]) => key === s.quantity)[1],
        label.split(",")[0],
        `${low} → ${high} ${unit}`,
        `${s.change > 0 ? "+" : ""}${number(s.change, 3)}`,
        s.elasticity == null ? "–" : number(s.elasticity, 2),
        html("span", { class: s.exceeds_numerical_error ? "badge good" : "badge warn" }, verdict),
      ];
    });
    return html("section", { class: "what-matters" }, html("h2", {}, "What matters most"), table("Change of each number over the range of each parameter by itself, the strongest first", ["number", "parameter", "range", "change", "elasticity", "numerical error"], rows));
  }
}
