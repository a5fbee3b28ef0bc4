// The slider of the shown time, with play; keys: arrows, page keys, Home and End on the slider.

import { button, html } from "../dom.js";
import { timeUnit, withUnit } from "../format.js";

/** Pictures per second while playing. */
const RATE = 8;

export class TimeBar {
  #times;
  #unit;
  #onChange;
  #slider;
  #output = html("output", { class: "time-output" });
  #play = button("▶ Play", () => this.toggle(), { class: "primary play", "aria-pressed": "false" });
  #timer = null;

  /** `times` [s] of the frames; `onChange(index)`. */
  constructor(times, end, onChange) {
    this.#times = times;
    this.#unit = timeUnit(end);
    this.#onChange = onChange;
    this.#slider = html("input", { type: "range", min: 0, max: Math.max(times.length - 1, 0), step: 1, value: 0, "aria-label": "Simulated time", oninput: () => this.go(Number(this.#slider.value)) });
    this.element = html("div", { class: "time-bar" }, this.#play, this.#slider, this.#output);
    this.index = 0;
  }

  /** Goes to a frame. */
  go(index) {
    this.index = Math.min(Math.max(index, 0), this.#times.length - 1);
    this.#slider.value = this.index;
    const { factor, name } = this.#unit;
    const words = withUnit(this.#times[this.index] * factor, name);
    this.#output.textContent = words;
    this.#slider.setAttribute("aria-valuetext", words);
    this.#onChange(this.index);
  }

  toggle() {
    if (this.#timer) return this.stop();
    this.#timer = setInterval(() => this.go((this.index + 1) % this.#times.length), 1000 / RATE);
    this.#show(true);
  }

  stop() {
    clearInterval(this.#timer);
    this.#timer = null;
    this.#show(false);
  }

  #show(isPlaying) {
    this.#play.textContent = isPlaying ? "❚❚ Pause" : "▶ Play";
    this.#play.setAttribute("aria-pressed", String(isPlaying));
  }
}
