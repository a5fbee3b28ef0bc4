// One curve of an answer: its computed points, and the curve through them with its errors.

import { followEvents, getJson, postJson } from "../api.js";
import { number, setting } from "../format.js";
import { crossingOf } from "../plots/answer_curve.js";
import { fitted } from "../scene/fit.js";
import { questionOf } from "../scene/question.js";

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
  #top;

  /** `top` is subtracted from what is computed, in its unit. */
  constructor(asked, name, top) {
    this.asked = asked;
    this.name = name;
    this.#top = top;
  }

  /** Asks the service, and calls `onChange()` with every point; returns when all is computed. */
  async ask(tissue, signal, onChange) {
    try {
      const question = questionOf(this.asked, tissue);
      this.count = question.cases.length + 1;
      const { id } = await postJson("/v1/what-if", question, { signal });
      this.id = id;
      onChange();
      await followEvents(`/v1/jobs/${id}/events`, ({ event, data }) => event === "case" && (this.#take(data), onChange()), signal);
      if (signal.aborted) return;
      const job = await getJson(`/v1/jobs/${id}`);
      if (job.state !== "succeeded") throw new Error(`The question ${job.state}: ${job.failure?.message ?? ""}`);
      this.#finish(await getJson(`/v1/jobs/${id}/summary`));
    } finally {
      this.isOpen = false;
    }
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
    this.effort = `${effort.computed} runs${effort.from_cache ? `, ${effort.from_cache} remembered` : ""}`;
    this.notice = notice;
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

/** From which speed on, in words, a level is exceeded by more than the uncertainty; `start` is the lowest speed. */
function beyond(to, start) {
  if (to == null) return ", though not beyond the uncertainty";
  return to <= start ? ", beyond the uncertainty" : `, beyond the uncertainty from ${number(to, 3)} m/s on`;
}

/** The answer of a curve in a sentence. */
export function sentenceOn(one) {
  const { asked, curve, failures, isOpen, points, reaches } = one;
  const { number: what, threshold } = asked;
  const missing = failures.length ? ` At ${failures.map(({ speed }) => setting(speed)).join(", ")} m/s the computation gives no result (${failures[0].reason}).` : "";
  if (isOpen) return "computing …";
  if (!curve || !points.length) return `no answer.${missing}`;
  const least = reaches.size ? ` At some of these speeds the stress reaches ${[...reaches].join(" and ")}: it would go deeper.` : "";
  if (!what.layer) {
    const [first, last] = [points[0], points.at(-1)];
    const words = ({ value, error, speed }) => `${number(value, 3)}${error == null ? "" : ` ± ${number(error, 2)}`} ${what.unit} at ${setting(speed)} m/s`;
    return `${words(first)}, ${words(last)}.${least}${missing}`;
  }
  const limit = `${setting(threshold)} kPa`;
  const speeds = curve.range;
  const all = `at all computed speeds, ${setting(speeds[0])} to ${setting(speeds[1])} m/s`;
  const { at, from, to, isAbove, falls } = crossingOf(curve, 0, speeds);
  if (falls) return `no one speed: the depth does not rise steadily with the speed, so that it crosses the top of the ${what.layer} more than once or downwards.${least}${missing}`;
  if (at == null && isAbove) return `the ${what.layer} exceeds ${limit} ${all}${beyond(to, speeds[0])}: ask about lower ones.${least}${missing}`;
  if (at == null) return `the ${what.layer} stays below ${limit} ${all}${from != null ? `; with the uncertainty it may exceed it from ${number(from, 3)} m/s on` : ""}.${missing}`;
  const between = `between ${from == null || from <= speeds[0] ? `less than ${setting(speeds[0])}` : number(from, 3)} and ${to == null ? `more than ${setting(speeds[1])}` : number(to, 3)} m/s with the uncertainty`;
  return `the ${what.layer} exceeds ${limit} from ${number(at, 3)} m/s on (${between}).${least}${missing}`;
}
