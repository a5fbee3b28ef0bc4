// The slider of the shown time, with play; keys on the slider: arrows for frames, page keys, Home and End.

import { button, html } from "../dom.js";
import { timeUnit, withUnit } from "../format.js";

/** A whole run plays in so many seconds; after a pause of the display [ms] it goes on from where it was. */
const [LENGTH, PAUSE] = [6, 250];
const PAGE = 10;

export class TimeBar {
  #times;
  #unit;
  #onChange;
  #slider;
  #output = html("output", { class: "time-output" });
  #play = button("▶ Play", () => this.toggle(), { class: "primary play", "aria-pressed": "false" });
  #timer = null;
  #isWaiting = false;
  /** The place between frames: 2.25 is a quarter of the way from the third to the fourth. */
  place = 0;

  /** Whether the reader has chosen a time. */
  isMoved = false;

  /** `times` [s] of the frames, of which the one at `place` is shown; `onChange(place)`. */
  constructor(times, end, onChange, place = 0) {
    this.#unit = timeUnit(end);
    this.#onChange = onChange;
    this.#slider = html("input", {
      type: "range", min: 0, step: "any", value: 0, "aria-label": "Simulated time",
      oninput: () => this.#choose(Number(this.#slider.value)), onkeydown: (event) => this.#key(event),
    });
    this.setTimes(times);
    this.place = place;
    this.#reportTime();
    this.element = html("div", { class: "time-bar" }, this.#play, this.#slider, this.#output);
  }

  /** Takes the times of the frames that there are; the shown time stays. */
  setTimes(times) {
    if (times.length === this.#times?.length) return;
    const shown = this.#times?.[this.index];
    this.#times = times;
    this.#slider.max = Math.max(times.length - 1, 0);
    this.place = Math.max(times.indexOf(shown), 0);
    this.#reportTime();
  }

  /** Number of the nearest frame. */
  get index() {
    return Math.round(this.place);
  }

  /** The simulated time at the place [s]. */
  get time() {
    const first = Math.min(Math.floor(this.place), this.#times.length - 1);
    const next = this.#times[first + 1] ?? this.#times[first];
    return this.#times[first] + (this.place - first) * (next - this.#times[first]);
  }

  /** Goes to a place between frames. */
  go(place) {
    this.place = Math.min(Math.max(place, 0), this.#times.length - 1);
    this.#reportTime();
    this.#onChange(this.place);
  }

  /** A time that the reader chooses. */
  #choose(place) {
    this.isMoved = true;
    this.stop();
    this.go(place);
  }

  /** Whether the picture of the time that is said is still on its way. */
  get isWaiting() {
    return this.#isWaiting;
  }

  set isWaiting(isWaiting) {
    if (isWaiting === this.#isWaiting) return;
    this.#isWaiting = isWaiting;
    this.#reportTime();
  }

  /** Says the time, in words and by the slider. */
  #reportTime() {
    this.#slider.value = this.place;
    const { factor, name } = this.#unit;
    const words = withUnit(this.time * factor, name) + (this.isWaiting ? " · reading" : "");
    this.#output.textContent = words;
    this.#slider.setAttribute("aria-valuetext", words);
  }

  /** Goes to a time [s], to the nearest that there is. */
  goToTime(time) {
    const away = this.#times.map((t) => Math.abs(t - time));
    this.#choose(away.indexOf(Math.min(...away)));
  }

  #key(event) {
    const last = this.#times.length - 1;
    const [before, after] = [Math.ceil(this.place) - 1, Math.floor(this.place) + 1];
    const goal = { ArrowLeft: before, ArrowDown: before, ArrowRight: after, ArrowUp: after, PageDown: before + 1 - PAGE, PageUp: after - 1 + PAGE, Home: 0, End: last }[event.key];
    if (goal == null) return;
    event.preventDefault();
    this.#choose(goal);
  }

  toggle() {
    this.isMoved = true;
    if (this.#timer) this.stop();
    else this.play();
  }

  /** Plays from where it is, over and over, at the rate of the display. */
  play() {
    if (this.#timer || this.#times.length < 2) return;
    let before = performance.now();
    const step = (now) => {
      const last = this.#times.length - 1;
      const next = this.place + (last * Math.min(Math.max(now - before, 0), PAUSE)) / (1000 * LENGTH);
      before = now;
      this.#timer = requestAnimationFrame(step);
      this.go(next > last ? (this.place < last ? last : 0) : next);
    };
    this.#timer = requestAnimationFrame(step);
    this.#show(true);
  }

  stop() {
    cancelAnimationFrame(this.#timer);
    this.#timer = null;
    this.#show(false);
  }

  #show(isPlaying) {
    this.#play.textContent = isPlaying ? "❚❚ Pause" : "▶ Play";
    this.#play.setAttribute("aria-pressed", String(isPlaying));
  }
}
