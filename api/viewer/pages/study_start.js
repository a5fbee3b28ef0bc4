// Studies of the computation, started from the form: error against run time of the scene, and stability of the engine.

import { postJson } from "../api.js";
import { button, checkbox, html, select } from "../dom.js";
import { problemWords } from "./scene_form.js";

/** Meshes by their level: numbers of elements in each direction. */
const MESHES = [["-2", "a quarter"], ["-1", "half as many"], ["0", "as given"], ["1", "twice as many"], ["2", "four times"]];

export class StudyStart {
  #scene;
  #coarsest = "-1";
  #finest = "1";
  #hasHalves = false;
  #isShort = true;
  #isImplicit = false;
  #state = html("p", { class: "field-error", "aria-live": "polite" });

  /** `scene()` is the scene document as it stands; null while it is none. */
  constructor(scene) {
    this.#scene = scene;
    const level = (label, from, to, value, take) => select(label, MESHES.slice(from, to), value, take);
    this.element = html("details", { class: "panel study-start" }, html("summary", {}, "Study the computation instead of running it once"),
      html("h2", {}, "Error against run time"),
      html("p", { class: "quiet" }, "This scene on meshes from coarse to fine: how large the error of each number is, what it costs, and which setting is the cheapest."),
      html("div", { class: "form-grid" },
        level("Elements in each direction, from", 0, 3, this.#coarsest, (value) => (this.#coarsest = value)), level("to", 2, 5, this.#finest, (value) => (this.#finest = value))),
      html("div", { class: "tools" },
        button("Start this study", () => this.#start(() => this.#errorStudy())),
        checkbox("also sizes in between", false, (isWanted) => (this.#hasHalves = isWanted))),
      html("h2", {}, "Stability"),
      html("p", { class: "quiet" }, "Stiff, slender, fast and extreme impacts of the program's own, whatever the scene: which finish, and which end with a diagnosis."),
      html("div", { class: "tools" },
        button("Start this study", () => this.#start(() => ({ kind: "stability", short: this.#isShort, implicit: this.#isImplicit ? [10, 100] : [] })), { "aria-label": "Start the study of stability" }),
        checkbox("the extremes only", true, (isWanted) => (this.#isShort = isWanted)),
        checkbox("with implicit steps, 10 and 100 times as long", false, (isWanted) => (this.#isImplicit = isWanted))),
      this.#state);
  }

  /** The scene without what refines its mesh: the study chooses the meshes. */
  #errorStudy() {
    const { accuracy: _, ...scene } = this.#scene() ?? {};
    return { kind: "error", scene, coarsest: Number(this.#coarsest), finest: Number(this.#finest), half_levels: this.#hasHalves };
  }

  async #start(study) {
    this.#state.textContent = "";
    try {
      const { id } = await postJson("/v1/studies", study());
      location.hash = `#/job/${id}`;
    } catch (error) {
      this.#state.textContent = [error.message, ...(error.body?.errors ?? []).map(problemWords)].join(" ");
    }
  }
}
