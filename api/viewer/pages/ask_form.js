// The question in a form: what hits, where, whom, how fast; with the sources of the values, and a drawing.

import { html, select } from "../dom.js";
import { setting } from "../format.js";
import { PROJECTILES } from "../scene/projectiles.js";
import { NUMBERS, fatOf, isDepth, sceneOf } from "../scene/question.js";
import { PERCENTILES, REGIONS } from "../scene/regions.js";
import { BOUNDS, THRESHOLD_KPA } from "./ask_address.js";
import { GeometryPreview } from "./geometry_preview.js";

/** A field for a number within bounds. */
export function numberInput(label, [min, max], value) {
  return html("input", { type: "number", min, max, step: "any", "aria-label": label, required: true, value });
}

export class AskForm {
  #tissue;
  #chosen;
  #onChange;
  #low;
  #high;
  #threshold;
  #thresholdField;
  #questions;
  #sources = html("div", { class: "quiet sources" });
  #preview = new GeometryPreview();

  /** `chosen` is {projectile, region, percent, number, speeds, threshold}; `ask` the buttons below the fields. */
  constructor(tissue, { speeds, threshold, ...chosen }, ask, onChange) {
    this.#tissue = tissue;
    this.#chosen = chosen;
    this.#onChange = onChange;
    this.#low = numberInput("From", BOUNDS.speed, speeds[0]);
    this.#high = numberInput("To", BOUNDS.speed, speeds[1]);
    this.#threshold = numberInput("Threshold of stress", BOUNDS.threshold, threshold);
    this.#thresholdField = html("div", { class: "field" }, html("span", {}, "Threshold"), html("span", { class: "pair" }, this.#threshold, "kPa"));
    this.#questions = html("select", { onchange: () => this.#choose({ number: NUMBERS.find(({ id }) => id === this.#questions.value) }) });
    const list = (items) => items.map(({ id, name }) => [id, name]);
    const one = (items, id) => items.find((item) => item.id === id);
    this.element = html("section", { class: "panel ask", "aria-label": "Question", oninput: (event) => event.target.type === "number" && this.#show() },
      select("What hits?", list(PROJECTILES), chosen.projectile.id, (id) => this.#takeProjectile(one(PROJECTILES, id))),
      select("Where?", list(REGIONS), chosen.region.id, (id) => this.#choose({ region: one(REGIONS, id) })),
      select("Who?", PERCENTILES.map(([percent, words]) => [String(percent), words]), String(chosen.percent), (percent) => this.#choose({ percent: Number(percent) })),
      html("label", { class: "field question" }, html("span", {}, "Question"), this.#questions),
      html("div", { class: "field" }, html("span", {}, "How fast?"), html("span", { class: "pair" }, this.#low, "to", this.#high, "m/s")),
      this.#thresholdField,
      html("div", { class: "tools wide" }, ask),
      this.#preview.element,
      this.#sources);
    this.#show();
  }

  leave() {
    this.#preview.leave();
  }

  #choose(choice) {
    Object.assign(this.#chosen, choice);
    this.#show();
  }

  #takeProjectile(projectile) {
    [this.#low.value, this.#high.value] = projectile.speed;
    this.#choose({ projectile });
  }

  /** What is asked now: what was chosen, with the fat of the person [m]; a sentence instead where it cannot be. */
  get asked() {
    const { region, percent, number } = this.#chosen;
    const [low, high, given] = [this.#low, this.#high, this.#threshold].map((input) => Number(input.value));
    const within = (value, [least, most]) => value >= least && value <= most;
    if (![low, high].every((speed) => within(speed, BOUNDS.speed))) return `The speeds must be from ${BOUNDS.speed.join(" to ")} m/s.`;
    if (!(high > 1.001 * low)) return "The speeds must differ, the lower one first.";
    const isGiven = within(given, BOUNDS.threshold);
    if (!isGiven && isDepth(number)) return `The stress threshold must be from ${BOUNDS.threshold.join(" to ")} kPa.`;
    return { ...this.#chosen, fat: fatOf(region, percent), threshold: isGiven ? given : THRESHOLD_KPA, speeds: [low, high] };
  }

  /** Shows what follows from the fields: the words of the questions, the drawing, the sources. */
  #show() {
    const { number, projectile, region, percent } = this.#chosen;
    const threshold = setting(Number(this.#threshold.value) || THRESHOLD_KPA);
    this.#questions.replaceChildren(...NUMBERS.map((one) => html("option", { value: one.id, selected: one === number }, one.words(threshold))));
    this.#thresholdField.hidden = !isDepth(number);
    const { asked } = this;
    if (typeof asked !== "string") this.#preview.show(sceneOf(asked, this.#tissue));
    this.#sources.replaceChildren(
      html("p", {}, html("b", {}, `${projectile.mass_g} g, ${projectile.diameter_mm} mm, ${projectile.hardness}. `), projectile.source),
      html("p", {}, html("b", {}, `Skin ${setting(region.skin_m * 1e3)} mm, fat ${setting(fatOf(region, percent) * 1e3)} mm. `), region.source),
      html("p", {}, html("b", {}, "Materials "), "of muscle, fat and skin: those of the example flashball_thigh, an assumption for impact rates; how well they fit a person is not part of the uncertainty."),
    );
    this.#onChange();
  }
}
