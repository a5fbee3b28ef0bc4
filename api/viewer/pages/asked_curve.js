// One curve of an answer: its computed points, and the curve through them with its errors.

import { followEvents, getJson } from "../api.js";
import { fitted } from "../scene/fit.js";
import { questionOf } from "../scene/question.js";
import { jobOf } from "./asked.js";

export class AskedCurve {
  /** {speed, value, error}, in the order of speeds; values are measured from `top`. */
  points = [];
  /** Reasons of the cases that have no number, with their speeds. */
  failures = [];
  /** {value(speed), error(speed), floor, range} once all is computed, from the lowest to the highest computed speed; null with too few points. */
  curve = null;
  isOpen = true;
  /** Ends of the model that the stress reaches at some speed: depths are at least so large. */
  reaches = new Set();
  isStopped = false;
  #top;
  #count = 0;
  #effort = "";
  #problem = null;

  /** `top` is subtracted from what is computed, in its unit. */
  constructor(asked, name, top) {
    this.asked = asked;
    this.name = name;
    this.#top = top;
  }

  /**
   * Follows the job `known` if there is one and it is of this question, else asks the service; calls `onChange()` with every point, and returns
   * when all is computed, was stopped or failed.
   */
  async ask(tissue, known, signal, onChange) {
    try {
      const question = questionOf(this.asked, tissue);
      this.#count = question.cases.length + 1;
      const id = await jobOf(question, signal, known);
      if (signal.aborted) return;
      this.id = id;
      onChange();
      await followEvents(`/v1/jobs/${id}/events`, ({ event, data }) => event === "case" && (this.#take(data), onChange()), signal);
      if (!signal.aborted) await this.#end(await getJson(`/v1/jobs/${id}`));
    } catch (error) {
      this.#problem = [error.message, ...(error.body?.errors ?? []).map((e) => e.message)].join(" ");
    } finally {
      this.isOpen = false;
    }
  }

  /** Where the computation stands, in words. */
  get state() {
    if (this.#problem) return this.#problem;
    const done = `${this.points.length + this.failures.length} of ${this.#count} speeds`;
    if (this.isOpen) return this.id ? `Computing: ${done} of “${this.name}”.` : "Asking …";
    return this.isStopped ? `Stopped: ${done} of “${this.name}” are computed.` : `Computed by ${this.#effort}`;
  }

  async #end({ state, failure, links }) {
    this.isStopped = state === "cancelled";
    if (links.summary) this.#finish(await getJson(links.summary));
    if (state === "failed") this.#problem = `The computation failed: ${failure?.message ?? "for no known reason"}`;
  }

  #take({ parameters: { speed }, numbers, ending, reason, reaches = [] }) {
    const quantity = numbers?.[this.asked.number.key];
    if (ending !== "finished" || quantity?.value == null) {
      this.failures.push({ speed, reason: reason ?? ending });
      return;
    }
    this.points.push({ speed, value: quantity.value - this.#top, error: quantity.error ?? null });
    this.points.sort((a, b) => a.speed - b.speed);
    reaches.forEach((end) => this.reaches.add(end.replace(/^the held nodes “(.*)”$/, "the $1")));
  }

  #finish({ cases, effort, notice }) {
    [this.points, this.failures] = [[], []];
    cases.forEach((one) => this.#take(one));
    this.#effort = `${effort.computed} runs${effort.from_cache ? `, ${effort.from_cache} remembered` : ""}. ${notice}`;
    const curve = fitted(this.points);
    // Nothing is less deep than the surface, and no force below 0.
    const range = [this.points[0]?.speed, this.points.at(-1)?.speed];
    if (curve) this.curve = { value: curve.value, error: (speed) => this.#errorAt(speed) + curve.error(speed), floor: -this.#top, range };
  }

  /** The numerical error between the computed points, linear; the nearest beyond them. */
  #errorAt(speed) {
    const known = this.points.filter(({ error }) => error != null);
    const after = known.findIndex((point) => point.speed >= speed);
    if (!known.length) return 0;
    if (after <= 0) return (after === 0 ? known[0] : known.at(-1)).error;
    const [a, b] = [known[after - 1], known[after]];
    return a.error + ((speed - a.speed) / (b.speed - a.speed)) * (b.error - a.error);
  }
}
