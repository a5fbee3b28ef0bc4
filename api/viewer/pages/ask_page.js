// A question as people ask it: this projectile, this part of this person, these speeds; the answer is a curve.

import { getJson } from "../api.js";
import { button, html, select } from "../dom.js";
import { setting } from "../format.js";
import { lineStyle } from "../plots/plot.js";
import { answerCurve } from "../plots/answer_curve.js";
import { PROJECTILES } from "../scene/projectiles.js";
import { PERCENTILES, REGIONS } from "../scene/regions.js";
import { NUMBERS, fatOf, topOf } from "../scene/question.js";
import { AskedCurve, sentenceOn } from "./asked_curve.js";

/** The preset whose materials of muscle, fat and skin are used: they are of the right size at impact rates. */
const MATERIALS = "flashball_thigh/scene.json";
const MORE_FAT_MM = 10;

export async function askPage() {
  const presets = await getJson("/viewer/presets.json");
  const scene = presets.find(({ file }) => file === MATERIALS)?.scene;
  const tissue = scene?.bodies.find(({ role }) => role === "tissue")?.parts;
  if (!tissue) throw new Error(`The service has no example ${MATERIALS}, whose materials are used here.`);
  const page = new AskPage(tissue);
  return { title: "Ask", element: page.element, leave: () => page.leave() };
}

class AskPage {
  #tissue;
  #projectile = PROJECTILES[0];
  #region = REGIONS[0];
  #percent = 50;
  #number = NUMBERS[0];
  #leaving = new AbortController();
  #curves = [];
  #sources = html("div", { class: "quiet sources" });
  #low = this.#numberInput("From", 1, 400);
  #high = this.#numberInput("To", 1, 400);
  #threshold = this.#numberInput("Threshold of stress", 0.1, 10000);
  #more = this.#numberInput("Millimetres more", 1, 40);
  #questions;
  #ask = button("Answer", () => this.#answer(), { class: "primary" });
  #further = html("div", { class: "tools", hidden: true });
  #state = html("p", { class: "quiet", "aria-live": "polite" });
  #picture = html("div");
  #answers = html("ul", { class: "answers" });

  constructor(tissue) {
    this.#tissue = tissue;
    this.#threshold.value = 100;
    this.#more.value = MORE_FAT_MM;
    this.#threshold.addEventListener("input", () => this.#nameQuestions());
    const list = (items) => items.map(({ id, name }) => [id, name]);
    const people = PERCENTILES.map(([percent, words]) => [String(percent), words]);
    this.#questions = html("select", { onchange: () => (this.#number = NUMBERS.find(({ id }) => id === this.#questions.value)) });
    this.#nameQuestions();
    const unit = (input, words) => html("span", { class: "pair" }, input, words);
    this.#further.append(button("And with more fat?", () => this.#withMoreFat()), html("label", { class: "pair" }, "by", this.#more, "mm"));
    this.element = html(
      "div",
      {},
      html("div", { class: "title" }, html("h1", {}, "Ask: at which speed?")),
      html("section", { class: "panel ask", "aria-label": "Question" },
        select("What hits?", list(PROJECTILES), this.#projectile.id, (id) => this.#takeProjectile(id)),
        select("Where?", list(REGIONS), this.#region.id, (id) => ((this.#region = REGIONS.find((one) => one.id === id)), this.#showSources())),
        select("Who?", people, String(this.#percent), (percent) => ((this.#percent = Number(percent)), this.#showSources())),
        html("div", { class: "field" }, html("span", {}, "How fast?"), html("span", { class: "pair" }, this.#low, "to", this.#high, "m/s")),
        html("label", { class: "field wide" }, html("span", {}, "Question"), this.#questions),
        html("div", { class: "field" }, html("span", {}, "Threshold"), unit(this.#threshold, "kPa")),
        html("div", { class: "tools wide" }, this.#ask),
        this.#sources),
      html("section", { class: "panel", "aria-label": "Answer" }, this.#answers, this.#picture, this.#further, this.#state),
    );
    this.#takeProjectile(this.#projectile.id);
    this.#state.textContent = "The answer is a curve against speed; its first points appear within a minute or two.";
  }

  leave() {
    this.#leaving.abort();
  }

  #numberInput(label, min, max) {
    return html("input", { type: "number", min, max, step: "any", "aria-label": label, required: true });
  }

  #takeProjectile(id) {
    this.#projectile = PROJECTILES.find((one) => one.id === id);
    [this.#low.value, this.#high.value] = this.#projectile.speed;
    this.#showSources();
  }

  #nameQuestions() {
    const words = setting(Number(this.#threshold.value) || 100);
    this.#questions.replaceChildren(...NUMBERS.map((one) => html("option", { value: one.id, selected: one === this.#number }, one.words(words))));
  }

  #showSources() {
    const { mass_g: mass, diameter_mm: diameter, hardness, source } = this.#projectile;
    const fat = fatOf(this.#region, this.#percent) * 1e3;
    this.#sources.replaceChildren(
      html("p", {}, html("b", {}, `${mass} g, ${diameter} mm, ${hardness}. `), source),
      html("p", {}, html("b", {}, `Skin ${setting(this.#region.skin_m * 1e3)} mm, fat ${setting(fat)} mm. `), this.#region.source),
      html("p", {}, html("b", {}, "Materials "), "of muscle, fat and skin: those of the example flashball_thigh, an assumption for impact rates; how well they fit a person is not part of the uncertainty."),
    );
  }

  /** What is asked now; a sentence instead where it cannot be. */
  #asked() {
    const [low, high, threshold] = [this.#low, this.#high, this.#threshold].map((input) => Number(input.value));
    if (!(low > 0 && high > low)) return "The speeds must both be above 0, the lower one first.";
    if (!(threshold > 0)) return "The stress threshold must be above 0 kPa.";
    return { projectile: this.#projectile, region: this.#region, fat: fatOf(this.#region, this.#percent), threshold, speeds: [low, high], number: this.#number };
  }

  #answer() {
    const asked = this.#asked();
    if (typeof asked === "string") return (this.#state.textContent = asked);
    this.#leaving.abort();
    this.#leaving = new AbortController();
    this.#curves = [];
    this.#further.hidden = true;
    return this.#add(asked, `${this.#region.name.toLowerCase()}, fat ${setting(asked.fat * 1e3)} mm`);
  }

  #withMoreFat() {
    const [first] = this.#curves;
    if (!first?.curve) return;
    const more = Number(this.#more.value);
    if (!(more > 0)) return (this.#state.textContent = "How many millimetres more?");
    const fat = first.asked.fat + more * 1e-3;
    return this.#add({ ...first.asked, fat }, `${setting(more)} mm more fat: ${setting(fat * 1e3)} mm`);
  }

  async #add(asked, name) {
    const { signal } = this.#leaving;
    const curve = new AskedCurve(asked, name, topOf(asked.number, asked.region, asked.fat));
    this.#curves.push(curve);
    this.#ask.disabled = true;
    this.#further.hidden = true;
    try {
      await curve.ask(this.#tissue, signal, () => this.#show());
      if (!signal.aborted) this.#state.textContent = `Computed by ${curve.effort}. ${curve.notice}`;
    } catch (error) {
      if (signal.aborted) return;
      this.#state.textContent = [error.message, ...(error.body?.errors ?? []).map((e) => e.message)].join(" ");
    } finally {
      if (!signal.aborted) {
        this.#ask.disabled = false;
        this.#further.hidden = this.#curves.length !== 1 || !this.#curves[0].curve;
      }
    }
    this.#show();
  }

  #show() {
    if (!this.#curves.length) return;
    const [{ asked }] = this.#curves;
    const { number } = asked;
    const level = number.layer ? 0 : null;
    const open = this.#curves.find((curve) => curve.isOpen);
    if (open) this.#state.textContent = `Computing: ${open.points.length + open.failures.length} of ${open.count} speeds of “${open.name}”.`;
    this.#picture.replaceChildren(
      answerCurve({ series: this.#curves, range: asked.speeds, axis: { label: number.axis(setting(asked.threshold)), unit: number.unit }, level, levelName: `top of the ${number.layer}` }),
      html("p", { class: "quiet" }, "● computed, with its numerical error · dashed: proposed between them, with a band of both errors", level == null ? "" : " · ○ where it crosses"),
    );
    this.#answers.replaceChildren(...this.#curves.map((curve, i) => {
      const item = html("li", {}, html("span", { class: "swatch", "aria-hidden": "true" }, "■"), " ", html("b", {}, curve.name), ": ", sentenceOn(curve), " ", curve.id ? html("a", { href: `#/job/${curve.id}` }, "all numbers") : "");
      item.firstChild.style.color = lineStyle(i).stroke;
      return item;
    }));
  }
}
