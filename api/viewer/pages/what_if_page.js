// What if it had been faster, elsewhere, with thinner fat? Sliders make cases, the service answers with four numbers each.

import { followEvents, getJson } from "../api.js";
import { button, checkbox, html } from "../dom.js";
import { setting } from "../format.js";
import { Recording } from "../recording/recording.js";
import { significantThreshold } from "../summary/headline.js";
import { jobOf, remember, stop } from "./asked.js";
import { WhatIfAnswer, numbersAbove } from "./what_if_answer.js";
import { WhatIfLimit } from "./what_if_limit.js";
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
  #limits = [];
  #leaving = new AbortController();
  #isOneAtATime = false;
  #isSampled = false;
  #proposal = new WhatIfProposal();
  #ask = button("What if?", () => this.#addCase(), { class: "primary" });
  #running = null;
  #stop = button("Stop", () => stop(this.#running).catch((error) => this.#refuse(error)), { class: "danger", hidden: true });
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
        html("div", { class: "tools" }, this.#ask, this.#stop, alone, sampled),
        parameters.length ? new WhatIfLimit(parameters, numbersAbove(threshold), (limit) => this.#findLimit(limit)).element : "",
        this.#proposal.element),
      html("section", { class: "panel" }, html("h2", {}, "Answers"), this.#state, this.#answers),
    );
  }

  leave() {
    this.#leaving.abort();
  }

  #slider({ name, label, unit, factor, base, low, high }) {
    const words = (value) => `${setting(Number((value * factor).toPrecision(3)))}${unit && unit !== "-" ? `\u202f${unit}` : ""}`;
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
    const set = Object.fromEntries(this.#values);
    const isNew = this.#values.size > 0 && !this.#cases.some((one) => isSame(one.set, set));
    if (!this.#cases.length && !this.#limits.length && !isNew && !this.#isOneAtATime && !this.#isSampled) {
      this.#state.textContent = "Move a slider first.";
      return;
    }
    if (isNew) this.#cases.push({ set });
    this.#answer().catch((error) => {
      if (isNew) this.#cases.pop();
      this.#refuse(error);
    });
  }

  /** Asks up to which value of a parameter a number stays below a limit, with what was asked before. */
  #findLimit(limit) {
    if (this.#ask.disabled) return;
    const before = this.#limits;
    if (!before.some((one) => JSON.stringify(one) === JSON.stringify(limit))) this.#limits = [...before, limit];
    this.#answer().catch((error) => {
      this.#limits = before;
      this.#refuse(error);
    });
  }

  #refuse(error) {
    if (this.#leaving.signal.aborted) return;
    this.#state.textContent = [error.message, ...(error.body?.errors ?? []).map((e) => `${e.pointer}: ${e.message}`)].join(" ");
    this.#setRunning(null);
  }

  /** What runs can be stopped, and nothing else is asked meanwhile. */
  #setRunning(id) {
    this.#running = id;
    this.#stop.hidden = !id;
    this.#ask.disabled = Boolean(id);
  }

  /** Goes on with a question that was asked before. Its cases by hand will be asked again with the next. */
  resume(question) {
    const again = async () => {
      const answer = await this.#follow(question);
      if (answer) [this.#cases, this.#limits] = [answer.asked, answer.askedLimits];
    };
    again().catch((error) => this.#refuse(error));
  }

  async #answer() {
    this.#ask.disabled = true;
    const asked = (name) => this.#cases.filter((one) => name in one.set).map((one) => one.set[name]);
    const isLimited = (name) => this.#limits.some(({ parameter }) => parameter === name);
    const varied = this.#parameters.filter(({ name, mayEnd }) => asked(name).length || isLimited(name) || ((this.#isOneAtATime || this.#isSampled) && !mayEnd));
    // Where the ends of the slider may lie beyond the scene, what was asked for is the range.
    const ends = ({ name, base, low, high, mayEnd }) => (mayEnd && !isLimited(name) ? [base, ...asked(name)] : [low, high]);
    const parameters = varied.map((one) => ({ name: one.name, change: one.change, low: Math.min(...ends(one)), high: Math.max(...ends(one)) }));
    const question = { job: this.#job.id, parameters, cases: this.#cases, one_at_a_time: this.#isOneAtATime, limits: this.#limits };
    if (this.#isSampled) question.sample = { method: "sobol", count: this.#sampleCount(), seed: 1 };
    const id = await jobOf(question);
    const page = `#/what-if/${this.#job.id}?job=${id}`;
    remember(id, page);
    // Whoever leaves while it computes comes back to it by the address; a page that was left has no say in that.
    if (this.#leaving.signal.aborted) return;
    history.replaceState(null, "", page);
    await this.#follow(id);
  }

  /** Shows the answer to a question as it comes; null when the page was left before its end, or there is none. */
  async #follow(id) {
    this.#setRunning(id);
    const { signal } = this.#leaving;
    const answer = new WhatIfAnswer(new Map(this.#parameters.map((parameter) => [parameter.name, parameter])), this.#threshold);
    this.#answers.replaceChildren(answer.element, html("p", {}, html("a", { href: `#/job/${id}` }, "This question among the jobs")));
    this.#state.textContent = "Computing; earlier answers are reused.";
    await followEvents(`/v1/jobs/${id}/events`, (event) => answer.take(event), signal);
    if (signal.aborted) return null;
    const { state, failure, links } = await getJson(`/v1/jobs/${id}`);
    const whole = links.summary && (await getJson(links.summary));
    if (signal.aborted) return null;
    if (state === "failed" || !whole) throw new Error(state === "cancelled" ? "Stopped before the first case." : `The question ${state}: ${failure?.message ?? ""}`);
    answer.takeAll(whole);
    this.#proposal.take(whole, answer.shown);
    this.#proposal.show(this.#sliderValues());
    this.#state.textContent = this.#endWords(state, whole);
    this.#setRunning(null);
    return answer;
  }

  #endWords(state, { effort, cases, requested_cases: requested, notice }) {
    const runs = `${effort.computed} runs computed, ${effort.from_cache} remembered. ${notice}`;
    return state === "cancelled" ? `Stopped: ${cases.length} of ${requested} cases, ${runs}` : `Done: ${runs}`;
  }
}

/** Whether two cases set the same values by name. */
function isSame(one, other) {
  const names = Object.keys(one);
  return names.length === Object.keys(other).length && names.every((name) => one[name] === other[name]);
}
