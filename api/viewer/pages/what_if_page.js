// What if it had been faster, elsewhere, with thinner fat? Sliders make cases, the service answers with four numbers each.

import { followEvents, getJson, postJson } from "../api.js";
import { button, checkbox, html } from "../dom.js";
import { withUnit } from "../format.js";
import { Recording } from "../recording/recording.js";
import { significantThreshold } from "../summary/headline.js";
import { questionPage, remember } from "./asked.js";
import { WhatIfAnswer } from "./what_if_answer.js";
import { parametersOf } from "./what_if_parameters.js";
import { WhatIfProposal } from "./what_if_proposal.js";

/** Cases spread over all sliders, for each coefficient of a polynomial of second degree. */
const CASES_PER_TERM = 1.6;

/** The page of an impact; with a question that was asked before, by the id of its job, also of that. */
export async function whatIfPage(id, question) {
  const job = await getJson(`/v1/jobs/${id}`);
  const scene = JSON.parse(await Recording.sceneText(`/v1/jobs/${id}/recording`));
  const summary = job.links.summary && await getJson(job.links.summary);
  const page = new WhatIfPage(job, parametersOf(scene), summary && significantThreshold(summary));
  if (question) page.resume(question);
  return { title: `What if: ${job.name}`, element: page.element, leave: () => page.leave() };
}

class WhatIfPage {
  #job;
  #parameters;
  #threshold;
  #values = new Map();
  #cases = [];
  #leaving = new AbortController();
  #isOneAtATime = false;
  #isSampled = false;
  #proposal = new WhatIfProposal();
  #ask = button("What if?", () => this.#addCase(), { class: "primary" });
  #state = html("p", { class: "quiet", "aria-live": "polite" }, "Move what should be different, then ask: each answer is a row, beside the one as it was.");
  #answers = html("div");

  /** `threshold` [Pa] is what depths of stress are above; null until it is known. */
  constructor(job, parameters, threshold) {
    this.#job = job;
    this.#threshold = threshold;
    this.#parameters = parameters;
    const sliders = parameters.map((parameter) => this.#slider(parameter));
    const alone = checkbox("also each one alone, at both ends of its slider: what matters most?", false, (isWanted) => (this.#isOneAtATime = isWanted));
    const sampled = checkbox(`also ${this.#sampleCount()} cases spread over all sliders: then moving one shows an estimate at once`, false, (isWanted) => (this.#isSampled = isWanted));
    this.element = html(
      "div",
      {},
      html("div", { class: "title" }, html("h1", {}, "What if?"), html("a", { class: "button", href: `#/job/${job.id}` }, `Back to ${job.name}`)),
      html("section", { class: "panel" },
        parameters.length ? html("div", { class: "what-if-sliders" }, sliders) : html("p", {}, "This scene has no projectile and no tissue to vary."),
        html("div", { class: "tools" }, this.#ask, alone, sampled),
        this.#proposal.element),
      html("section", { class: "panel" }, html("h2", {}, "Answers"), this.#state, this.#answers),
    );
  }

  leave() {
    this.#leaving.abort();
  }

  #slider({ name, label, unit, factor, base, low, high }) {
    const words = (value) => withUnit(value * factor, unit, 3);
    const output = html("output", {}, `${words(base)}, as it was`);
    const input = html("input", {
      type: "range", min: low, max: high, step: (high - low) / 100, value: base, "aria-valuetext": words(base),
      oninput: () => {
        const value = Number(input.value);
        const isBase = Math.abs(value - base) < (high - low) / 150;
        if (isBase) this.#values.delete(name);
        else this.#values.set(name, value);
        output.textContent = isBase ? `${words(base)}, as it was` : words(value);
        input.setAttribute("aria-valuetext", output.textContent);
        this.#proposal.show(this.#sliderValues());
      },
    });
    const ends = html("span", { class: "ends quiet", "aria-hidden": "true" }, html("span", {}, words(low)), html("span", {}, words(high)));
    return html("label", { class: "field" }, html("span", {}, label), input, ends, output);
  }

  /** Where all sliders stand, by name. */
  #sliderValues() {
    return new Map(this.#parameters.map(({ name, base }) => [name, this.#values.get(name) ?? base]));
  }

  /** Enough for polynomials of second degree in all parameters. */
  #sampleCount() {
    const count = this.#parameters.filter(({ mayEnd }) => !mayEnd).length;
    return Math.ceil((CASES_PER_TERM * (count + 1) * (count + 2)) / 2);
  }

  /** Asks for the case of the sliders, with those asked for before: they are known already. */
  #addCase() {
    if (this.#values.size) this.#cases.push({ set: Object.fromEntries(this.#values) });
    if (!this.#cases.length && !this.#isOneAtATime && !this.#isSampled) {
      this.#state.textContent = "Move a slider first.";
      return;
    }
    this.#answer().catch((error) => {
      this.#cases.pop();
      this.#refuse(error);
    });
  }

  #refuse(error) {
    this.#state.textContent = [error.message, ...(error.body?.errors ?? []).map((e) => `${e.pointer}: ${e.message}`)].join(" ");
    this.#ask.disabled = false;
  }

  /** Goes on with a question that was asked before. Its cases by hand will be asked again with the next. */
  resume(question) {
    const again = async () => {
      const answer = await this.#follow(question);
      if (answer) this.#cases = answer.asked;
    };
    again().catch((error) => this.#refuse(error));
  }

  async #answer() {
    this.#ask.disabled = true;
    const asked = (name) => this.#cases.filter((one) => name in one.set).map((one) => one.set[name]);
    const varied = this.#parameters.filter(({ name, mayEnd }) => asked(name).length || ((this.#isOneAtATime || this.#isSampled) && !mayEnd));
    // Where the ends of the slider may lie beyond the scene, what was asked for is the range.
    const ends = ({ name, base, low, high, mayEnd }) => (mayEnd ? [base, ...asked(name)] : [low, high]);
    const parameters = varied.map((one) => ({ name: one.name, change: one.change, low: Math.min(...ends(one)), high: Math.max(...ends(one)) }));
    const question = { job: this.#job.id, parameters, cases: this.#cases, one_at_a_time: this.#isOneAtATime };
    if (this.#isSampled) question.sample = { method: "sobol", count: this.#sampleCount(), seed: 1 };
    const { id } = await postJson("/v1/what-if", question);
    remember(id, this.#job.id);
    // Whoever leaves while it computes comes back to it by the address; a page that was left has no say in that.
    if (!this.#leaving.signal.aborted) history.replaceState(null, "", questionPage(this.#job.id, id));
    await this.#follow(id);
  }

  /** Shows the answer to a question as it comes; null when the page was left before its end. */
  async #follow(id) {
    this.#ask.disabled = true;
    const { signal } = this.#leaving;
    const answer = new WhatIfAnswer(new Map(this.#parameters.map((parameter) => [parameter.name, parameter])), this.#threshold);
    this.#answers.replaceChildren(answer.element, html("p", {}, html("a", { href: `#/job/${id}` }, "This question among the jobs")));
    this.#state.textContent = "Computing; earlier answers are reused.";
    await followEvents(`/v1/jobs/${id}/events`, (event) => answer.take(event), signal);
    if (signal.aborted) return null;
    const ended = await getJson(`/v1/jobs/${id}`);
    if (ended.state !== "succeeded") throw new Error(`The question ${ended.state}: ${ended.failure?.message ?? ""}`);
    const whole = await getJson(`/v1/jobs/${id}/summary`);
    answer.takeAll(whole);
    this.#proposal.take(whole, answer.shown);
    this.#proposal.show(this.#sliderValues());
    this.#state.textContent = `Done: ${whole.effort.computed} runs computed, ${whole.effort.from_cache} remembered. ${whole.notice}`;
    this.#ask.disabled = false;
    return answer;
  }
}
