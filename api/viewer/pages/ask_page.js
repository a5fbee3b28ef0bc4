// A question as people ask it: this projectile, this part of this person, these speeds; the answer is a curve.

import { getJson } from "../api.js";
import { button, html } from "../dom.js";
import { setting } from "../format.js";
import { lineStyle } from "../plots/plot.js";
import { answerCurve, sizeNow } from "../plots/answer_curve.js";
import { answerLegend } from "../plots/answer_legend.js";
import { answerTable } from "../plots/answer_table.js";
import { hardnessesFrom } from "../scene/own_ball.js";
import { bordersOf } from "../scene/question.js";
import { BOUNDS, addressOf, questionIn } from "./ask_address.js";
import { AskForm, numberInput } from "./ask_form.js";
import { remember, stop } from "./asked.js";
import { AskedCurve } from "./asked_curve.js";
import { differenceOf } from "./asked_difference.js";
import { sentenceOn } from "./asked_words.js";

/** The preset whose materials of muscle, fat and skin are used: they are of the right size at impact rates. */
const MATERIALS = "flashball_thigh/scene.json";
/** Screens on which the answer stands above the question, and the question alone until there is one. */
const NARROW = "(max-width: 1099px)";

/** The page of the question in an address, with its answer if it has the jobs of one. */
export async function askPage(query) {
  const [presets, library] = await Promise.all([getJson("/viewer/presets.json"), getJson("/v1/materials")]);
  const scene = presets.find(({ file }) => file === MATERIALS)?.scene;
  const tissue = scene?.bodies.find(({ role }) => role === "tissue")?.parts;
  if (!tissue) throw new Error(`The service has no example ${MATERIALS}, whose materials are used here.`);
  const hardnesses = hardnessesFrom(library);
  const page = new AskPage({ tissue, hardnesses }, questionIn(query, hardnesses));
  return { title: "Ask", element: page.element, leave: () => page.leave() };
}

class AskPage {
  #tissue;
  #form;
  #more;
  #leaving = new AbortController();
  #curves = [];
  #ask = button("Answer", () => this.#answer(), { class: "primary" });
  /** Why a question is not asked, beside the button. */
  #refused = html("p", { class: "field-error", role: "alert", hidden: true });
  #stop = button("Stop", () => this.#stopAll(), { class: "danger", hidden: true });
  #further = html("div", { class: "tools", hidden: true });
  #moreFat = button("And with more fat?", () => this.#withMoreFat());
  /** On narrow screens, where the question is below its answer. */
  #toQuestion = button("Change the question", () => this.#form.element.scrollIntoView(), { class: "to-question", hidden: true });
  #before = html("p", { class: "notice-line", hidden: true }, "This is the answer to the question before it was changed. Press Answer for the new one.");
  #width = 0;
  /** Draws the answer anew where the window has another size for it. */
  #onResize = () => {
    const [width] = sizeNow();
    if (this.#curves.length && width !== this.#width) this.#draw(this.#curves[0].asked);
  };
  #state = html("div", { class: "quiet states", "aria-live": "polite" }, "The answer is a curve against speed; its first points appear within a minute or two.");
  #picture = html("div");
  #answers = html("ul", { class: "answers" });
  #difference = html("p", { class: "difference", hidden: true });
  #panel = html("section", { class: "panel ask-answer", "aria-label": "Answer" }, this.#before, this.#answers, this.#difference, this.#picture, this.#further, this.#state, this.#toQuestion);

  constructor(materials, { more, jobs, ...question }) {
    this.#tissue = materials.tissue;
    window.addEventListener("resize", this.#onResize);
    this.#more = numberInput("Millimetres more", BOUNDS.more, more);
    this.#further.append(this.#moreFat, html("label", { class: "pair" }, "by", this.#more, "mm"));
    this.#form = new AskForm(materials, question, [this.#ask, this.#stop, this.#refused], () => this.#onChange());
    this.element = html(
      "div",
      {},
      html("div", { class: "title" }, html("h1", {}, "Ask: at which speed?")),
      html("div", { class: "ask-page" }, this.#form.element, this.#panel),
    );
    if (jobs.length) this.#begin(this.#form.asked, jobs);
  }

  leave() {
    window.removeEventListener("resize", this.#onResize);
    this.#leaving.abort();
    this.#form.leave();
  }

  /** Something of the question was changed: an answer is that of the question before; without one, the address is that of the question. */
  #onChange() {
    const asked = this.#form?.asked;
    this.#refused.hidden = true;
    if (!asked || typeof asked === "string") return;
    if (this.#curves.length) this.#show();
    else history.replaceState(null, "", addressOf(asked));
  }

  #answer() {
    const { asked } = this.#form;
    this.#refused.hidden = typeof asked !== "string";
    if (typeof asked === "string") return (this.#refused.textContent = asked);
    this.#begin(asked, []);
    if (matchMedia(NARROW).matches) this.#panel.scrollIntoView();
  }

  /** Asks, or follows the `jobs` that were asked before: of the question, and of the same with more fat. */
  #begin(asked, [first, second]) {
    this.#leaving.abort();
    this.#leaving = new AbortController();
    this.#curves = [];
    this.#add(asked, `${asked.region.name.toLowerCase()}, fat ${setting(asked.fat * 1e3)} mm`, first);
    if (second) this.#withMoreFat(second);
  }

  /** The same with more fat, as it is set, in place of what was asked so before. */
  #withMoreFat(job) {
    const [first] = this.#curves;
    const more = Number(this.#more.value);
    if (!first) return;
    if (!(more >= BOUNDS.more[0] && more <= BOUNDS.more[1])) return (this.#state.textContent = `More fat must be from ${BOUNDS.more.join(" to ")} mm.`);
    const fat = first.asked.fat + more * 1e-3;
    this.#curves = [first];
    this.#add({ ...first.asked, fat, more }, `${setting(more)} mm more fat: ${setting(fat * 1e3)} mm`, job);
  }

  async #add(asked, name, job) {
    const { signal } = this.#leaving;
    const curve = new AskedCurve(asked, name);
    this.#curves.push(curve);
    this.#show();
    await curve.ask(this.#tissue, job, signal, () => this.#show());
    if (!signal.aborted) this.#show();
  }

  #stopAll() {
    const open = this.#curves.filter((curve) => curve.isOpen && curve.id);
    open.forEach(({ id }) => stop(id).catch((error) => (this.#state.textContent = error.message)));
  }

  #show() {
    const [first] = this.#curves;
    const { asked } = first;
    const now = this.#form.asked;
    const isBefore = typeof now === "string" || addressOf(now) !== addressOf(asked);
    this.#keepAddress();
    this.#panel.classList.toggle("before", isBefore);
    this.#before.hidden = !isBefore;
    const open = this.#curves.filter(({ isOpen }) => isOpen);
    this.#ask.disabled = open.length > 0;
    this.#stop.hidden = !open.some(({ id }) => id);
    this.#further.hidden = !first.points.length;
    this.#toQuestion.hidden = false;
    this.#moreFat.disabled = isBefore || open.length > 0;
    const notices = [...new Set(this.#curves.map(({ notice }) => notice))].filter(Boolean);
    this.#state.replaceChildren(...this.#curves.map(({ name, state }) => html("p", {}, html("b", {}, name), `: ${state}`)), ...notices.map((notice) => html("p", {}, notice)));
    this.#draw(asked);
  }

  /** The answer can be found again by its address: here, by the list of jobs, and by others. */
  #keepAddress() {
    const known = this.#curves.filter(({ id }) => id);
    if (!this.#curves[0].id) return;
    const page = addressOf(this.#curves[0].asked, known.map(({ id }) => id), this.#curves[1]?.asked.more);
    if (page === location.hash) return;
    history.replaceState(null, "", page);
    known.forEach(({ id }) => remember(id, page));
  }

  /** Borders of layers that all curves have in common: with another thickness of the fat those below it are elsewhere. */
  #borders() {
    const [first, ...others] = this.#curves.map(({ asked }) => bordersOf(asked));
    return first.filter(({ name, at }) => others.every((borders) => borders.some((one) => one.name === name && one.at === at)));
  }

  #draw({ number, threshold, speeds }) {
    [this.#width] = sizeNow();
    const level = number.layer ? 0 : null;
    const answer = { series: this.#curves, axis: { label: number.axis(setting(threshold)), unit: number.unit } };
    const isOpen = this.#picture.querySelector("details")?.open ?? false;
    this.#picture.replaceChildren(
      answerCurve({ ...answer, range: speeds, level, levelName: `top of the ${number.layer}`, borders: this.#borders() }),
      answerLegend(this.#curves, level),
      answerTable(answer, isOpen),
    );
    this.#difference.textContent = differenceOf(this.#curves);
    this.#difference.hidden = !this.#difference.textContent;
    this.#answers.replaceChildren(...this.#curves.map((curve, i) => {
      const item = html("li", {}, html("span", { class: "swatch", "aria-hidden": "true" }, "■"), " ", html("b", {}, curve.name), ": ", sentenceOn(curve), " ", curve.id ? html("a", { href: `#/job/${curve.id}` }, "all numbers") : "");
      item.firstChild.style.color = lineStyle(i).stroke;
      return item;
    }));
  }
}
