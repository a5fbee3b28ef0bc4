// A new impact: an example or an earlier job, changed in a form or as JSON, validated by the service as one types.

import { ApiProblem, getJson, postJson } from "../api.js";
import { button, html, select, table } from "../dom.js";
import { bytes, number } from "../format.js";
import { Recording } from "../recording/recording.js";
import { inWords } from "../scene/scene_units.js";
import { stillness } from "../scene/stillness.js";
import { plainly } from "../summary/plain_terms.js";
import { GeometryPreview } from "./geometry_preview.js";
import { OwnTarget } from "./own_target.js";
import { wholeRunWords } from "./run_time.js";
import { SceneForm, problemWords } from "./scene_form.js";
import { StudyStart } from "./study_start.js";

/** Rest after the last key before the service is asked [ms]. */
const REST = 350;
/** On a narrower screen the section with sizes is closed at first [px]. */
const NARROW = 560;

/** `isRefined`: an earlier job, now with the accuracy of a new impact. */
export async function submitPage(jobId, isRefined = false) {
  const presets = await getJson("/viewer/presets.json");
  const page = new SubmitPage(presets);
  const text = jobId && await Recording.sceneText(`/v1/jobs/${jobId}/recording`);
  page.take(!jobId ? pretty(refined(presets[0].scene)) : isRefined ? pretty({ ...JSON.parse(text), accuracy: ACCURACY }) : text);
  return { title: "New impact", element: page.element, leave: () => page.leave() };
}

/** The accuracy of a new impact: that of `contuse run` for scenes that state none. */
const ACCURACY = { relative: 0.1, time_budget_s: 20, reproducible: true };

/** A scene with that accuracy, if a projectile hits a tissue with a mesh and nothing is stated. */
function refined(scene) {
  const { bodies = [], accuracy, solver } = scene;
  const has = (role) => bodies.find((body) => body.role === role);
  if (accuracy || solver?.error_bars || !has("projectile") || !has("tissue")?.mesh) return scene;
  return { ...scene, accuracy: ACCURACY };
}

/** JSON with short arrays on one line. */
function pretty(value) {
  const text = JSON.stringify(value, null, 2);
  return text.replace(/\[\s+([^[\]{}]+?)\s+\]/g, (_, inner) => `[${inner.replace(/\s*\n\s*/g, " ")}]`);
}

class SubmitPage {
  #document = null;
  #form = new SceneForm(() => this.#fromForm());
  #own = new OwnTarget(ACCURACY, (scene) => (this.take(pretty(scene)), this.#form.element.scrollIntoView({ block: "nearest" })));
  #text = html("textarea", { spellcheck: "false", "aria-label": "Scene as JSON", oninput: () => this.#fromText() });
  #meshes = select("Meshes", [["refined", "refined until errors are below 10 %"], ["own", "as given"]], "own", (choice) => this.#refine(choice === "refined"));
  #pointers = html("ul", { class: "pointers" });
  #verdict = html("div", { "aria-live": "polite" });
  #preview = html("div");
  #section = new GeometryPreview();
  /** The bodies in space, once the service has answered; its modules are large and come after the form. */
  #picture = null;
  #space = html("div", { class: "space" });
  #submit = button("Run this impact", () => this.#run(), { class: "primary", disabled: true });
  #timer = null;
  #asked = 0;
  #asking = null;
  #hasLeft = false;
  /** Makes a repeated submission of the same document the same job. */
  #key = null;
  /** Descriptions of the examples. */
  #ofExamples;

  constructor(presets) {
    this.#ofExamples = new Set(presets.map(({ scene }) => scene.description));
    const options = presets.map(({ file, scene }) => [file, scene.name]);
    const choose = (file) => this.take(pretty(refined(presets.find((preset) => preset.file === file).scene)));
    this.element = html(
      "div",
      {},
      html("div", { class: "title" }, html("h1", {}, "New impact"), select("Begin with", options, options[0][0], choose), this.#meshes),
      this.#own.element,
      html(
        "div",
        { class: "editor" },
        html("section", { class: "panel", "aria-label": "Form" }, this.#form.element),
        html("div", { class: "beside" },
          html("section", { class: "panel", "aria-label": "Geometry" }, html("h2", {}, "What it would be"), this.#space, html("details", { class: "sizes", open: innerWidth > NARROW }, html("summary", {}, "Section with sizes"), this.#section.element), this.#preview),
          html("details", { class: "panel json" }, html("summary", {}, "The same as JSON, in SI units"), this.#text, this.#pointers)),
      ),
      new StudyStart(() => this.#document).element,
      html("section", { class: "panel verdict" }, html("div", { class: "row" }, this.#verdict, this.#submit)),
    );
  }

  leave() {
    this.#own.leave();
    this.#hasLeft = true;
    this.#picture?.leave();
    this.#section.leave();
    clearTimeout(this.#timer);
    this.#asking?.abort();
  }

  take(text) {
    this.#text.value = text;
    this.#fromText();
  }

  #fromText() {
    try {
      this.#document = JSON.parse(this.#text.value);
      if (this.#document && typeof this.#document === "object") this.#form.show(this.#document);
    } catch {
      // Half-written JSON: the service says where it breaks off, and the form keeps what it had.
    }
    this.#changed();
  }

  /** Requires the accuracy of a new impact, or none. */
  #refine(isRefined) {
    if (!this.#document) return;
    const { accuracy: _, ...own } = this.#document;
    this.take(pretty(isRefined ? { ...own, accuracy: ACCURACY } : own));
  }

  #fromForm() {
    // What an example says of itself is not so of one that was changed.
    if (this.#ofExamples.has(this.#document.description)) delete this.#document.description;
    this.#text.value = pretty(this.#document);
    this.#changed();
  }

  #changed() {
    this.#key = null;
    const choice = this.#meshes.querySelector("select") ?? this.#meshes;
    choice.value = this.#document?.accuracy ? "refined" : "own";
    this.#submit.disabled = true;
    // What was said of the scene before says nothing of this one, nor does an answer that is under way.
    this.#asked++;
    this.#asking?.abort();
    this.#showProblems([]);
    this.#preview.replaceChildren();
    this.#verdict.replaceChildren(html("span", { class: "badge busy" }, "checking"), " …");
    this.#space.classList.add("stale");
    this.#section.show(this.#document);
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#validate(), REST);
  }

  #showProblems(problems) {
    this.#form.showProblems(problems);
    this.#pointers.replaceChildren(...problemsOfJson(problems));
    this.#own.showProblems(this.#document, problems);
  }

  async #validate() {
    const asked = ++this.#asked;
    this.#asking?.abort();
    this.#asking = new AbortController();
    try {
      const answer = await postJson("/v1/jobs/validate?geometry=true", this.#text.value, { signal: this.#asking.signal });
      if (asked !== this.#asked) return;
      this.#accept(answer);
      await this.#showGeometry(answer.geometry, asked);
    } catch (error) {
      if (asked === this.#asked && error.name !== "AbortError") this.#refuse(error);
    }
  }

  #accept(answer) {
    const { plan } = answer;
    const warnings = [...answer.warnings, ...stillness(this.#document)];
    this.#showProblems(warnings);
    this.#submit.disabled = false;
    const name = this.#document?.name ? `${this.#document.name}: ` : "";
    const facts = `${name}${plan.elements} elements, at least ${plan.expected_steps} steps, ${bytes(plan.memory_bytes)}; ${wholeRunWords(this.#document, plan.expected_run_time_s)}`;
    this.#verdict.replaceChildren(html("span", { class: "badge good" }, "ready to run"), ` ${facts}`, problemList(warnings, this.#form));
    // Generated meshes have no badly shaped elements.
    const hasShapes = answer.bodies.some((body) => body.min_scaled_jacobian);
    const shapeOf = (body) => (body.min_scaled_jacobian ? number(body.min_scaled_jacobian, 2) : "–");
    const bodies = answer.bodies.map((body) => [body.name, body.elements || "rigid", number(body.mass_kg * 1e3), ...(hasShapes ? [shapeOf(body)] : [])]);
    this.#preview.replaceChildren(
      table("Bodies", ["body", "elements", "mass [g]", ...(hasShapes ? ["smallest scaled Jacobian"] : [])], bodies),
      ...(plan.capped_bulk_moduli ? [aboutStiffness(plan.capped_bulk_moduli)] : []),
      html("details", {}, html("summary", {}, "What the scene does not need"), html("p", { class: "quiet" }, plan.omitted.map((item) => item.what).join("; "), ".")),
    );
  }

  /** Shows the bodies in space; those of a scene that is too large to be sent are drawn as a section only. */
  async #showGeometry(geometry, asked) {
    if (!geometry) return this.#space.replaceChildren(html("p", { class: "quiet" }, "The meshes are too large to be shown before they run."));
    const { ScenePicture } = await import("../picture/scene_picture.js");
    if (this.#hasLeft || asked !== this.#asked) return;
    this.#picture ??= new ScenePicture();
    this.#picture.show(geometry, this.#document);
    this.#space.replaceChildren(this.#picture.element);
    this.#space.classList.remove("stale");
  }

  #refuse(error) {
    this.#submit.disabled = true;
    const body = error instanceof ApiProblem ? error.body : { detail: error.message };
    const problems = body.errors ?? [];
    this.#showProblems(problems);
    this.#preview.replaceChildren();
    const where = body.line ? ` Line ${body.line}, column ${body.column}.` : "";
    this.#verdict.replaceChildren(html("span", { class: "badge bad" }, "not yet"), problems.length ? ` ${problems.length === 1 ? "one problem" : `${problems.length} problems`}:` : ` ${body.detail ?? error.message}${where}`, problemList(problems, this.#form));
  }

  async #run() {
    this.#submit.disabled = true;
    this.#key ??= crypto.getRandomValues(new Uint32Array(4)).join("-");
    try {
      const job = await postJson("/v1/jobs", this.#text.value, { headers: { "Idempotency-Key": this.#key } });
      location.hash = `#/job/${job.id}`;
    } catch (error) {
      this.#refuse(error);
      this.#submit.disabled = false;
    }
  }
}

/** That bulk moduli are below that of water, in a sentence; which, and what that changes, are behind it. */
function aboutStiffness(words) {
  const isUnknown = words.includes("Effect not known");
  const short = `Materials are less stiff against compression than water; what that changes ${isUnknown ? "is not known before the run" : "is known from other impacts"}.`;
  return html("details", { class: "note" }, html("summary", {}, short, " ", html("b", {}, "More")), html("p", { class: "quiet" }, plainly(inWords(words)), "."));
}

/** Problems with the names of their fields, each leads to its place in the form. */
function problemList(problems, form) {
  if (!problems.length) return "";
  const item = (problem) =>
    html("li", {}, html("a", { href: "", onclick: (event) => (event.preventDefault(), form.focus(problem)) }, form.nameOf(problem.pointer)), ": ", plainly(problemWords(problem)));
  return html("ul", { class: "problems" }, form.withTexts(problems).map(item));
}

/** Problems as the service words them, in SI units, with their JSON pointers. */
function problemsOfJson(problems) {
  const words = ({ message, limit, remedy }) => [message, limit && `(limit: ${limit})`, remedy && `— ${remedy}`].filter(Boolean).join(" ");
  return problems.map((problem) => html("li", {}, html("code", {}, problem.pointer || "/"), ` ${words(problem)}`));
}
