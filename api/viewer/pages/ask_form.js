// The question in a form: what hits, where, whom, how fast; with the sources of the values, and a drawing.

import { html, select } from "../dom.js";
import { setting } from "../format.js";
import { SPEED as SPEED_OF_OWN, ownBall, unusualBall } from "../scene/own_ball.js";
import { PROJECTILES } from "../scene/projectiles.js";
import { NUMBERS, fatOf, isDepth, sceneOf } from "../scene/question.js";
import { PERCENTILES, REGIONS } from "../scene/regions.js";
import { BOUNDS, OWN, THRESHOLD_KPA } from "./ask_address.js";
import { GeometryPreview } from "./geometry_preview.js";

/** A field for a number within bounds. */
export function numberInput(label, [min, max], value) {
  return html("input", { type: "number", min, max, step: "any", "aria-label": label, required: true, value });
}

/** Bounds in words, "from 1 to 40". */
const between = (bounds) => `from ${bounds.join(" to ")}`;
const within = (value, [least, most]) => value >= least && value <= most;

export class AskForm {
  #tissue;
  #hardnesses;
  #chosen;
  #diameter;
  #mass;
  #ballFields;
  #fat;
  #fatField;
  #onChange;
  #low;
  #high;
  #threshold;
  #thresholdField;
  #questions;
  #sources = html("div", { class: "quiet sources" });
  #preview = new GeometryPreview();

  /**
   * `tissue` are the parts with their materials, `hardnesses` what a ball can be made of; `chosen` is what an address says; `ask` the buttons below
   * the fields.
   */
  constructor({ tissue, hardnesses }, { speeds, threshold, ...chosen }, ask, onChange) {
    [this.#tissue, this.#hardnesses, this.#chosen, this.#onChange] = [tissue, hardnesses, chosen, onChange];
    this.#makeOwnFields(chosen);
    this.#low = numberInput("From", BOUNDS.speed, speeds[0]);
    this.#high = numberInput("To", BOUNDS.speed, speeds[1]);
    this.#threshold = numberInput("Threshold of stress", BOUNDS.threshold, threshold);
    this.#thresholdField = html("div", { class: "field" }, html("span", {}, "Threshold"), html("span", { class: "pair" }, this.#threshold, "kPa"));
    this.#questions = html("select", { onchange: () => this.#choose({ number: NUMBERS.find(({ id }) => id === this.#questions.value) }) });
    const list = (items) => items.map(({ id, name }) => [id, name]);
    const one = (items, id) => items.find((item) => item.id === id);
    this.element = html("section", { class: "panel ask", "aria-label": "Question", oninput: (event) => event.target.type === "number" && this.#show() },
      select("What hits?", [...list(PROJECTILES), [OWN, "A ball of your own"]], chosen.hit, (id) => this.#takeProjectile(id)),
      this.#ballFields,
      select("Where?", list(REGIONS), chosen.region.id, (id) => this.#choose({ region: one(REGIONS, id) })),
      select("Who?", [...PERCENTILES.map(([percent, words]) => [String(percent), words]), [OWN, "a thickness of your own"]], String(chosen.percent), (percent) => this.#choose({ percent: percent === OWN ? OWN : Number(percent) })),
      this.#fatField,
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

  /** The fields of a ball and of a thickness of the reader's own. */
  #makeOwnFields({ ball, ownFat }) {
    this.#diameter = numberInput("Diameter", BOUNDS.diameter, ball.diameter_mm);
    this.#mass = numberInput("Mass", BOUNDS.mass, ball.mass_g);
    const pick = (id) => this.#choose({ ball: { hardness: this.#hardnesses.find((one) => one.id === id) } });
    const made = select("Made of", this.#hardnesses.map(({ id, name }) => [id, name]), ball.hardness.id, pick);
    const field = (words, input, unit) => html("div", { class: "field" }, html("span", {}, words), html("span", { class: "pair" }, input, unit));
    this.#ballFields = html("div", { class: "own-ball wide" }, field("Diameter", this.#diameter, "mm"), field("Mass", this.#mass, "g"), made);
    this.#fat = numberInput("Thickness of the fat", BOUNDS.fat, ownFat);
    this.#fatField = field("Fat", this.#fat, "mm");
  }

  #takeProjectile(hit) {
    const known = PROJECTILES.find(({ id }) => id === hit);
    [this.#low.value, this.#high.value] = known?.speed ?? SPEED_OF_OWN;
    this.#choose({ hit });
  }

  /** What hits; a sentence instead where it cannot be. */
  get #projectile() {
    const { hit, ball } = this.#chosen;
    if (hit !== OWN) return PROJECTILES.find(({ id }) => id === hit);
    const [diameter_mm, mass_g] = [this.#diameter, this.#mass].map((input) => Number(input.value));
    if (!within(diameter_mm, BOUNDS.diameter)) return `The diameter must be ${between(BOUNDS.diameter)} mm.`;
    if (!within(mass_g, BOUNDS.mass)) return `The mass must be ${between(BOUNDS.mass)} g.`;
    return ownBall({ diameter_mm, mass_g, hardness: ball.hardness });
  }

  /** Why the thickness of the fat cannot be asked about, in a sentence; null where it can. */
  get #problemOfFat() {
    const isOwn = this.#chosen.percent === OWN;
    return isOwn && !within(Number(this.#fat.value), BOUNDS.fat) ? `The thickness of the fat must be ${between(BOUNDS.fat)} mm.` : null;
  }

  /** What is asked now: what was chosen, with the fat of the person [m]; a sentence instead where it cannot be. */
  get asked() {
    const { region, percent, number } = this.#chosen;
    const [low, high, given, ownFat] = [this.#low, this.#high, this.#threshold, this.#fat].map((input) => Number(input.value));
    const projectile = this.#projectile;
    if (typeof projectile === "string") return projectile;
    const isOwnFat = percent === OWN;
    if (this.#problemOfFat) return this.#problemOfFat;
    if (![low, high].every((speed) => within(speed, BOUNDS.speed))) return `The speeds must be ${between(BOUNDS.speed)} m/s.`;
    if (!(high > 1.001 * low)) return "The speeds must differ, the lower one first.";
    const isGiven = within(given, BOUNDS.threshold);
    if (!isGiven && isDepth(number)) return `The stress threshold must be ${between(BOUNDS.threshold)} kPa.`;
    // To a tenth of a millimetre, as that of a percentile.
    const fat = isOwnFat ? Math.round(ownFat * 10) / 1e4 : fatOf(region, percent);
    return { projectile, region, percent, number, ownFat: Number((fat * 1e3).toPrecision(3)), fat, threshold: isGiven ? given : THRESHOLD_KPA, speeds: [low, high] };
  }

  /** Shows what follows from the fields: the words of the questions, the drawing, the sources. */
  #show() {
    const { number, region, hit, percent } = this.#chosen;
    const threshold = setting(Number(this.#threshold.value) || THRESHOLD_KPA);
    this.#questions.replaceChildren(...NUMBERS.map((one) => html("option", { value: one.id, selected: one === number }, one.words(threshold))));
    this.#thresholdField.hidden = !isDepth(number);
    this.#ballFields.hidden = hit !== OWN;
    this.#fatField.hidden = percent !== OWN;
    const { asked } = this;
    // The drawing of what was asked before is pale while this cannot be.
    this.#preview.element.classList.toggle("stale", typeof asked === "string");
    if (typeof asked !== "string") this.#preview.show(sceneOf(asked, this.#tissue));
    const projectile = this.#projectile;
    const fat = percent === OWN ? Math.round(10 * Number(this.#fat.value)) / 10 : fatOf(region, percent) * 1e3;
    const problem = (words) => html("p", { class: "field-error" }, words);
    const unusual = hit === OWN && typeof projectile !== "string" && unusualBall(projectile);
    this.#sources.replaceChildren(
      typeof projectile === "string" ? problem(projectile) : html("p", {}, html("b", {}, `${projectile.mass_g} g, ${projectile.diameter_mm} mm, ${projectile.hardness}. `), projectile.source),
      ...(unusual ? [problem(unusual)] : []),
      this.#problemOfFat ? problem(this.#problemOfFat) : html("p", {}, html("b", {}, `Skin ${setting(region.skin_m * 1e3)} mm, fat ${setting(fat)} mm. `), percent === OWN ? `Fat as you gave it. Skin: ${region.source}` : region.source),
      html("p", {}, html("b", {}, "Materials "), "of muscle, fat and skin: those of the example flashball_thigh, an assumption for impact rates; how well they fit a person is not part of the uncertainty."),
    );
    this.#onChange();
  }
}
