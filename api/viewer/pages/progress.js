// How far a job is: in words, and as a panel that follows it.

import { ApiProblem, postJson } from "../api.js";
import { button, html } from "../dom.js";
import { number, timeUnit, withUnit } from "../format.js";

/** Whether a job counts runs, as what-if questions and studies do: its steps take it nowhere in simulated time. */
function isStudy({ step, simulated_time_s }) {
  return step > 0 && simulated_time_s === 0;
}

/** How far a job is, in words: simulated time of an impact, runs of a question. */
export function reached(job) {
  if (isStudy(job)) return `${job.step}${job.expected_steps ? ` of ${job.expected_steps}` : ""} runs`;
  if (job.step === 0) return "–";
  const { factor, name } = timeUnit(job.end_time_s);
  return `${withUnit(job.simulated_time_s * factor, name)} of ${withUnit(job.end_time_s * factor, name)}`;
}

/** The bar, the words and the log of a job that waits or runs. */
export class ProgressPanel {
  #bar = html("progress", { max: 1, value: 0, "aria-label": "Progress of the job" });
  #words = html("p", { "aria-live": "polite" });
  #look;
  #log = html("ol", { class: "event-log" });

  constructor(job, peek) {
    this.job = job;
    const cancel = button("Cancel", () => postJson(`/v1/jobs/${job.id}/cancel`, {}).catch((e) => this.#note(e.message)), { class: "danger" });
    this.#look = button("Look at it now", () => peek().catch((e) => this.#note(e instanceof ApiProblem ? e.message : String(e))));
    this.#words.textContent = job.queue_position ? `Waiting: number ${job.queue_position} in the queue.` : "Waiting for news.";
    this.element = html("section", { class: "panel progress-panel" }, html("h2", {}, "Progress"), this.#bar, this.#words, html("div", { class: "tools" }, this.#look, cancel), this.#log);
  }

  #note(words) {
    this.#log.prepend(html("li", {}, words));
  }

  take({ event, data }) {
    if (event !== "progress") {
      this.#note(event);
      return;
    }
    this.#bar.value = data.progress;
    // Many runs behind one job leave no recording to look at.
    if (isStudy(data)) this.#look.remove();
    const left = data.eta_s == null ? "" : `, about ${number(data.eta_s, 2)} s left`;
    const steps = isStudy(data) ? "" : `step ${data.step}${data.expected_steps ? ` of about ${data.expected_steps}` : ""}, `;
    this.#words.textContent = data.step === 0 ? `${data.phase}${left}` : `${data.phase}: ${steps}${reached({ ...this.job, ...data })}${left}`;
    this.#note(`${data.phase} · ${Math.round(100 * data.progress)} % · ${isStudy(data) ? "run" : "step"} ${data.step}`);
  }
}
