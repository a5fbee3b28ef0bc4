// One curve of an answer: its computed points, and the curve through them with its errors.

import { followEvents, getJson } from "../api.js";
import { setting } from "../format.js";
import { fitted } from "../scene/fit.js";
import { endsWithin, possibleOf } from "../scene/possible.js";
import { endOf, isDepth, questionOf, topOf } from "../scene/question.js";
import { jobOf } from "./asked.js";

/** Why a number of a case is a lower bound, in words. */
function cutBy({ reaches = [] }, number) {
  const ends = reaches.map((end) => end.replace(/^the held nodes “(.*)”$/, "the $1").replace(/ of the model$/, ""));
  return ends.length && isDepth(number) ? `the stress reaches ${ends.join(" and ")}, where the model ends` : "it was still growing when the computed time ended";
}

/** Neighbouring points that all have a property, run by run. */
function runsOf(points, has) {
  const runs = points.reduce((all, point) => (has(point) ? [...all.slice(0, -1), [...all.at(-1), point]] : [...all, []]), [[]]);
  return runs.filter((run) => run.length);
}

/** The longest run of neighbouring points whose values are known. */
function longestKnown(points) {
  return runsOf(points, ({ least }) => !least).reduce((best, run) => (run.length > best.length ? run : best), []);
}

/** The speeds [first, last] between which all neighbouring points have a known error. */
function stretchesOf(points) {
  const runs = runsOf(points, ({ error }) => error != null).filter((run) => run.length > 1);
  return runs.map((run) => [run[0].speed, run.at(-1).speed]);
}

export class AskedCurve {
  /**
   * {speed, value, error, lower, upper, least}, in the order of speeds; values are measured from the top of the layer. `lower` and `upper` are the
   * ends of the value with its error, within what is possible. `least` says in words why the value is a lower bound; null where it is none.
   */
  points = [];
  /** Reasons of the cases that have no number, with their speeds. */
  failures = [];
  /**
   * {value(speed), lower(speed), upper(speed), range, isLeast, stretches} once all is computed, over the longest range of speeds whose values are known;
   * `isLeast` where too few are, and it goes through lower bounds: then nothing is known above it. `stretches` are the speeds [first, last] between
   * neighbouring points whose errors are known: `lower` and `upper` are those of speeds within them. Null with too few points.
   */
  curve = null;
  isOpen = true;
  isStopped = false;
  /** What the service says of its results; empty until they are there. */
  notice = "";
  #possible;
  #top;
  #count = 0;
  #effort = "";
  #problem = null;

  constructor(asked, name) {
    this.asked = asked;
    this.name = name;
    this.#top = topOf(asked.number, asked.region, asked.fat);
    this.#possible = possibleOf(asked.number.key, asked);
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
    if (this.isOpen) return this.id ? `computing, ${done}.` : "asking …";
    return this.isStopped ? `stopped, ${done} are computed.` : `computed by ${this.#effort}`;
  }

  async #end({ state, failure, links }) {
    this.isStopped = state === "cancelled";
    if (links.summary) this.#finish(await getJson(links.summary));
    if (state === "failed") this.#problem = `The computation failed: ${failure?.message ?? "for no known reason"}`;
  }

  #take(one) {
    const { parameters: { speed }, numbers, ending, reason, lower_bounds: bounds = [] } = one;
    const { number } = this.asked;
    const quantity = numbers?.[number.key];
    if (ending !== "finished" || quantity?.value == null) {
      this.failures.push({ speed, reason: reason ?? ending });
      return;
    }
    const [value, error] = [quantity.value - this.#top, quantity.error ?? null];
    const [lower, upper] = this.#band(speed, value, error ?? 0);
    this.points.push({ speed, value, error, lower, upper, least: bounds.includes(number.key) ? cutBy(one, number) : null });
    this.points.sort((a, b) => a.speed - b.speed);
  }

  /** Both ends of a value with its error, within what is possible at a speed. */
  #band(speed, value, error) {
    return endsWithin(this.#possible(speed).map((end) => end - this.#top), value, error);
  }

  #finish({ cases, effort, notice }) {
    [this.points, this.failures] = [[], []];
    cases.forEach((one) => this.#take(one));
    const lasting = cases.filter(({ lower_bounds: bounds }) => bounds?.includes("impulse_n_s")).length;
    const until = lasting ? `after which contact goes on at ${lasting} of the speeds, so that numbers may still grow` : "until contact has ended";
    const covered = `Each covers ${setting(endOf(this.asked) * 1e3)} ms, ${until}.`;
    this.#effort = `${effort.computed} runs${effort.from_cache ? `, ${effort.from_cache} remembered` : ""}. ${covered}`;
    this.notice = notice;
    const known = longestKnown(this.points);
    const fit = fitted(known);
    this.curve = fit ? this.#curveOf(fit, known, false) : this.#curveOf(fitted(this.points), this.points, true);
  }

  /** A fit through points with its band, where the errors of neighbouring points are known. */
  #curveOf(fit, points, isLeast) {
    if (!fit) return null;
    const range = [points[0].speed, points.at(-1).speed];
    const band = (speed) => this.#band(speed, fit.value(speed), errorAt(points, speed) + fit.error(speed));
    const upper = isLeast ? fit.value : (speed) => band(speed)[1];
    return { value: fit.value, lower: (speed) => band(speed)[0], upper, range, isLeast, stretches: stretchesOf(points) };
  }
}

/** The numerical error at a speed within computed points: that of a point, linear between two. */
function errorAt(points, speed) {
  const after = points.findIndex((point) => point.speed >= speed);
  if (points[after].speed === speed) return points[after].error;
  const [a, b] = [points[after - 1], points[after]];
  return a.error + ((speed - a.speed) / (b.speed - a.speed)) * (b.error - a.error);
}
