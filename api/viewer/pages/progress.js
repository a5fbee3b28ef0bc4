// How far a job is: in words, and as a panel that follows it.

import { postJson } from "../api.js";
import { button, html } from "../dom.js";
import { number, timeUnit, timeWords, withUnit } from "../format.js";

/** Whether a job counts runs, as what-if questions and studies do: its steps take it nowhere in simulated time. */
function isStudy({ step, simulated_time_s }) {
  return step > 0 && simulated_time_s === 0;
}

/** How far a job is, in words: simulated time of an impact, runs of a question. */
export function reached(job) {
  if (isStudy(job)) return `${job.step}${job.expected_steps ? ` of ${job.expected_steps}` : ""} runs`;
  if (job.step === 0) return "–";
  const { factor, name } = timeUnit(job.end_time_s);
  return `${withUnit(job.simulated_time_s * factor, name)} of ${timeWords(job.end_time_s)}`;
}

/** Phases in words; the others as they are. */
const PHASES = { loading: "loading: meshes are read and scans are meshed", estimating_errors: "estimating errors", dynamic_relaxation: "dynamic relaxation" };

/** Where a run to an accuracy stands: it takes finer and finer meshes, how many is not known in advance. */
function meshWords({ run, mesh_factor: factor, requested, before }) {
  const percent = (fraction) => `± ${number(100 * fraction, 2)} %`;
  const bars = before == null ? "" : `; error bars of the mesh before: up to ${percent(before)}, ${percent(requested)} are requested`;
  return `mesh ${run}, with ${number(factor, 2)} × the elements of the scene in each direction${bars}`;
}

/** The bar, the words and the log of a job that waits or runs. */
export class ProgressPanel {
  #bar = html("progress", { max: 1, value: 0, "aria-label": "Progress of the job" });
  #words = html("p", { "aria-live": "polite" });
  #look;
  #said = html("p", { class: "quiet", "aria-live": "polite" });
  #log = html("ol", { class: "event-log" });
  #lines = new Map();
  #clock = null;

  constructor(job, peek) {
    this.job = job;
    const cancel = button("Cancel", () => postJson(`/v1/jobs/${job.id}/cancel`, {}).catch((e) => this.#say(e.message)), { class: "danger" });
    this.#look = button("Look at it now", () => this.#peek(peek), { hidden: true });
    this.#words.textContent = job.queue_position ? `Waiting: number ${job.queue_position} of your own jobs.` : "Waiting for news.";
    this.element = html("section", { class: "panel progress-panel" }, html("h2", {}, "Progress"), this.#bar, this.#words, html("div", { class: "tools" }, this.#look, cancel), this.#said, this.#log);
  }

  /** Loading, which takes minutes for a large scan and reports nothing: shows that time goes on. */
  #begin(since) {
    clearInterval(this.#clock);
    this.#bar.removeAttribute("value");
    const tick = () => (this.#words.textContent = `${PHASES.loading}, ${Math.max(0, Math.round((Date.now() - since) / 1000))} s`);
    tick();
    this.#clock = setInterval(() => (this.element.isConnected ? tick() : clearInterval(this.#clock)), 1000);
  }

  #say(words) {
    this.#said.textContent = words;
  }

  /** Looks at what is recorded; where nothing is yet, the button waits for the next step. */
  async #peek(peek) {
    this.#look.disabled = true;
    this.#say("");
    try {
      const isThere = await peek();
      this.#look.disabled = !isThere;
      if (!isThere) this.#say("There is nothing to look at yet: the first instants are still being written.");
    } catch (error) {
      this.#say(error.message);
    }
  }

  /** The first line of the log; of each `subject` there is one, which says where it stands. */
  #note(words, subject = words) {
    if (!this.#lines.has(subject)) this.#lines.set(subject, html("li"));
    const line = this.#lines.get(subject);
    line.textContent = words;
    if (this.#log.firstChild !== line) this.#log.prepend(line);
  }

  take({ event, data }) {
    if (event !== "progress") {
      this.#note(event);
      if (event === "running") this.#begin(this.job.started_at ? Date.parse(this.job.started_at) : Date.now());
      return;
    }
    if (data.phase === "loading") return;
    const phase = PHASES[data.phase] ?? data.phase;
    clearInterval(this.#clock);
    // Only what the run itself steps through is recorded, and many runs behind one job leave nothing to look at.
    this.#look.hidden = data.phase !== "stepping" || data.step === 0 || isStudy(data);
    this.#look.disabled = false;
    const percent = `${Math.round(100 * data.progress)} %`;
    if (data.accuracy) this.#note(`${data.progress > 0 ? `${percent} · ` : ""}${meshWords(data.accuracy)}`, data.accuracy.run);
    if (data.accuracy && data.progress === 0) {
      this.#bar.removeAttribute("value");
      this.#words.textContent = `Running ${meshWords(data.accuracy)}`;
      return;
    }
    this.#bar.value = data.progress;
    const left = data.eta_s == null ? "" : `, about ${number(data.eta_s, 2)} s left`;
    const steps = isStudy(data) ? "" : `step ${data.step}${data.expected_steps ? ` of about ${data.expected_steps}` : ""}, `;
    this.#words.textContent = data.step === 0 ? `${phase}${left}` : `${phase}: ${steps}${reached({ ...this.job, ...data })}${left}`;
    if (!data.accuracy) this.#note(data.step === 0 ? phase : `${phase} · ${percent} · ${isStudy(data) ? "run" : "step"} ${data.step}`, data.phase);
  }
}
