// A mesh or a scan of the reader's own as the target: upload, what is in it, what its parts are, where it is hit; then the scene of it.

import { getJson, upload } from "../api.js";
import { button, html, select, table } from "../dom.js";
import { bytes, number, setting } from "../format.js";
import { FIXED, GIVEN, OMITTED, STIFF, guessOf, isScan, ownScene, tissueOf } from "../scene/own_scene.js";
import { PROJECTILES, rigidBall } from "../scene/projectiles.js";

const ACCEPT = ".msh,.inp,.vtu,.vtk,.k,.key,.dyn,.feb,.bdf,.nas,.nii,.gz,.nrrd,.mha";
/** Nastran files have no certain beginning. */
const FORMAT_BY_NAME = /\.(bdf|nas)$/i;
const WAYS = [["0,0,-1", "from above (−z)"], ["0,0,1", "from below (+z)"], ["0,-1,0", "from the front (−y)"], ["0,1,0", "from behind (+y)"], ["-1,0,0", "from the right (−x)"], ["1,0,0", "from the left (+x)"]];
const OWN_BALL = "own";
/** Rest after the last key before the service is asked where the ball touches [ms]. */
const REST = 300;
/** Elements at the impact against those of the whole scan [-]. */
const FINER = 0.5;

const millimetres = (box) => box[1].map((high, k) => setting(Number((1e3 * (high - box[0][k])).toPrecision(3)))).join(" × ");

export class OwnTarget {
  #onScene;
  #accuracy;
  #leaving = new AbortController();
  #file = html("input", { type: "file", accept: ACCEPT, onchange: () => this.#take(this.#file.files[0]) });
  #bar = html("progress", { max: "1", value: "0", hidden: true, "aria-label": "Upload" });
  #state = html("div", { "aria-live": "polite" });
  #contents = html("div");
  #chosen = null;
  #timer = null;
  /** Uploads, and questions where the ball touches: only the last of each counts. */
  #asked = 0;
  #aimed = 0;

  /** `onScene(scene)` takes the finished scene; `accuracy` is that of a new impact. */
  constructor(accuracy, onScene) {
    this.#accuracy = accuracy;
    this.#onScene = onScene;
    this.element = html("details", { class: "panel own-target" }, html("summary", {}, "Begin with a mesh or a scan of your own"),
      html("label", { class: "field" }, html("span", {}, "Mesh (.msh, .inp, .vtu, .vtk, .k, .feb, .bdf) or scan with labels (.nii, .nii.gz, .nrrd, .mha)"), this.#file),
      this.#bar, this.#state, this.#contents);
  }

  leave() {
    clearTimeout(this.#timer);
    this.#leaving.abort();
  }

  /** Uploads a file and shows what the service finds in it. */
  async #take(file) {
    if (!file) return;
    const asked = ++this.#asked;
    this.#leaving.abort();
    const { signal } = (this.#leaving = new AbortController());
    this.#contents.replaceChildren();
    this.#bar.hidden = false;
    const sent = (part) => {
      this.#bar.value = part;
      this.#state.textContent = part < 1 ? `Sending ${file.name}: ${Math.round(100 * part)} %` : `The service reads ${file.name} …`;
    };
    sent(0);
    try {
      const format = FORMAT_BY_NAME.test(file.name) ? "?format=bdf" : "";
      const mesh = await upload(`/v1/meshes${format}`, file, sent, signal);
      const [first, materials] = await Promise.all([getJson(`/v1/meshes/${mesh.id}/first-scene`), getJson("/v1/materials")]);
      if (asked === this.#asked) this.#show(file, mesh, first, materials);
    } catch (error) {
      if (asked === this.#asked && !signal.aborted) this.#refuse(file.name, error);
    } finally {
      if (asked === this.#asked) this.#bar.hidden = true;
    }
  }

  #refuse(name, error) {
    const words = [error.message, error.body?.remedy].filter(Boolean).join(" ");
    this.#state.replaceChildren(html("p", { class: "alert", role: "alert" }, `${name} cannot be used: ${words}`));
  }

  #show(file, mesh, first, materials) {
    const tissue = tissueOf(first.scene);
    const scan = isScan(tissue);
    const names = [...new Set(first.parts.map(({ part }) => part))];
    const uses = new Map(names.map((name) => [name, guessOf(first.scene, name)]));
    const held = new Set((tissue.fixed ?? []).map(({ set }) => set).filter((set) => first.sets.includes(set)));
    const size = tissue.mesh.segmentation?.size_m;
    this.#chosen = { id: mesh.id, file: file.name, name: file.name.replace(/\.(nii\.gz|[^.]*)$/i, ""), first, uses, held, projectile: PROJECTILES.at(-1), way: WAYS[0][0], through: null };
    this.#state.textContent = [
      `${file.name}: ${bytes(mesh.bytes)}, ${mesh.elements} ${scan ? "voxels with labels" : `elements, ${mesh.nodes} nodes`}`,
      `box ${millimetres(this.#box(first.parts))} mm${tissue.placement?.scale === 1e-3 ? " (its numbers are taken as millimetres)" : ""}`, ...mesh.notes.filter((note) => !note.startsWith("label ")),
    ].join("; ");
    const rows = names.map((name) => {
      const own = first.parts.filter(({ part }) => part === name);
      const volume = own.reduce((sum, { volume_m3 }) => sum + volume_m3, 0);
      return [name, this.#use(name, materials, scan), number(1e6 * volume, 3), millimetres(this.#box(own))];
    });
    this.#size = this.#field("Size of the elements [mm]", size && setting(1e3 * size));
    this.#near = this.#field("Size at the impact [mm]", size && setting(1e3 * Number((FINER * size).toPrecision(2))));
    const fields = [
      select("What hits?", [...PROJECTILES.map(({ id, name }) => [id, name]), [OWN_BALL, "a rigid ball of my own"]], this.#chosen.projectile.id, (id) => this.#takeProjectile(id)),
      this.#diameter.field, this.#mass.field,
      select("From where?", WAYS, this.#chosen.way, (way) => ((this.#chosen.way = way), this.#aim())),
      this.#speed.field,
      html("div", { class: "field", role: "group", "aria-label": "Point of impact" }, html("span", {}, "Point of impact, x y z [mm]"), html("span", { class: "vector" }, this.#point)),
      ...(scan ? [this.#size.field, this.#near.field] : []),
      this.#end.field,
      select("Accuracy", [["own", "elements as given"], ["refined", "refined until errors are below 10 %"]], "own", (choice) => (this.#chosen.accuracy = choice === "refined" ? this.#accuracy : null)),
    ];
    this.#contents.replaceChildren(
      table(scan ? "Labels, and what they are" : "Parts, and what they are", [scan ? "label" : "part", "what it is", "volume [cm³]", "box [mm]"], rows),
      first.sets.length ? html("fieldset", { class: "held" }, html("legend", {}, "Held without motion at"), first.sets.map((set) => this.#hold(set))) : "",
      html("div", { class: "form-grid" }, fields),
      html("div", { class: "tools" }, button("Use it as the target", () => this.#make(), { class: "primary" }), this.#verdict),
    );
    this.#takeProjectile(this.#chosen.projectile.id);
  }

  /** The box around parts. */
  #box(parts) {
    const corner = (of, end) => [0, 1, 2].map((k) => of(...parts.map(({ bounding_box_m }) => bounding_box_m[end][k])));
    return [corner(Math.min, 0), corner(Math.max, 1)];
  }

  #use(name, materials, scan) {
    const { uses } = this.#chosen;
    const families = Map.groupBy(materials, ({ name: set }) => set.split("/")[0]);
    const option = (value, words = value) => html("option", { value, selected: value === uses.get(name) }, words);
    const choice = html("select", { "aria-label": `What is ${name}?`, onchange: () => uses.set(name, choice.value) },
      uses.get(name) === GIVEN ? option(GIVEN, "as the file says") : option("", "not chosen yet"),
      html("optgroup", { label: "bone and outside" }, scan ? option(FIXED, "bone, rigid and fixed") : "", option(STIFF, "bone, stiff, moves"), option(OMITTED, "no part of the body")),
      [...families].map(([family, sets]) => html("optgroup", { label: family }, sets.map((set) => option(set.name)))));
    return choice;
  }

  #hold(set) {
    const { held } = this.#chosen;
    const box = html("input", { type: "checkbox", checked: held.has(set), onchange: () => (box.checked ? held.add(set) : held.delete(set)) });
    return html("label", { class: "check" }, box, set);
  }

  /** A number with its label. */
  #field(words, value, onchange = () => {}) {
    const input = html("input", { type: "text", inputmode: "decimal", value, oninput: onchange });
    return { input, field: html("label", { class: "field" }, html("span", {}, words), input), read: () => Number(input.value.trim().replace(",", ".") || NaN) };
  }

  #size = null;
  #near = null;
  #verdict = html("span", { "aria-live": "polite", class: "field-error" });
  #diameter = this.#field("Diameter [mm]", "40", () => this.#takeProjectile(OWN_BALL));
  #mass = this.#field("Mass [g]", "100", () => this.#takeProjectile(OWN_BALL));
  #speed = this.#field("Speed [m/s]", "10");
  #end = this.#field("Time to simulate [ms]", "5");
  #point = ["x", "y", "z"].map((axis) => html("input", { type: "text", inputmode: "decimal", "aria-label": `Point of impact, ${axis} [mm]`, oninput: () => this.#takePoint() }));

  #takeProjectile(id) {
    const known = PROJECTILES.find((one) => one.id === id);
    if (known) [this.#diameter.input.value, this.#mass.input.value] = [setting(known.diameter_mm), setting(known.mass_g)];
    const [diameter, mass] = [this.#diameter.read(), this.#mass.read()];
    for (const { input } of [this.#diameter, this.#mass]) input.disabled = Boolean(known);
    this.#chosen.projectile = known ?? (diameter > 0 && mass > 0 ? rigidBall(diameter, mass) : null);
    this.#aim();
  }

  #takePoint() {
    const point = this.#point.map(({ value }) => Number(value.trim().replace(",", ".") || NaN) * 1e-3);
    this.#chosen.through = point.every(Number.isFinite) ? point : null;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#aim(), REST);
  }

  /** Asks the service where the ball touches the target on its way. */
  async #aim() {
    const chosen = this.#chosen;
    const asked = ++this.#aimed;
    chosen.touch = null;
    this.#verdict.textContent = "";
    if (!chosen.projectile) return;
    const through = chosen.through ? `&through_m=${chosen.through.join(",")}` : "";
    try {
      const { touches } = await getJson(`/v1/meshes/${chosen.id}/first-scene?radius_m=${chosen.projectile.diameter_mm / 2e3}${through}`);
      if (asked !== this.#aimed) return;
      chosen.touch = touches.find(({ direction }) => direction.join(",") === chosen.way) ?? null;
      if (!chosen.touch) this.#verdict.textContent = "On this way the ball misses: choose another point, or come from elsewhere.";
      else if (!chosen.through) this.#point.forEach((input, k) => (input.value = setting(Number((1e3 * chosen.touch.point_m[k]).toFixed(2)))));
    } catch (error) {
      if (asked === this.#aimed) this.#verdict.textContent = error.message;
    }
  }

  /** Hands the scene over, or says what is missing. */
  async #make() {
    // Of what stands there now, however recently it was typed.
    clearTimeout(this.#timer);
    await this.#aim();
    const { uses, held, touch } = this.#chosen;
    const scan = this.#size.input.isConnected;
    const [speed, end, size, near] = [this.#speed.read(), 1e-3 * this.#end.read(), 1e-3 * this.#size.read(), 1e-3 * this.#near.read()];
    const miss = this.#verdict.textContent;
    const missing = [
      ...[...uses].filter(([, use]) => !use).map(([name]) => `what ${name} is`),
      ...[[touch, "a place where it touches"], [speed > 0, "a speed"], [end > 0, "a time"], [!scan || (size > 0 && near > 0), "sizes of the elements"]].filter(([has]) => !has).map(([, words]) => words),
    ];
    this.#verdict.textContent = missing.length ? `Still missing: ${missing.join(", ")}. ${miss}` : "";
    if (missing.length) return;
    const digits = (x) => Number(x.toPrecision(6));
    const within = this.#chosen.projectile.diameter_mm / 4e3;
    this.#onScene(ownScene({ ...this.#chosen, held: [...held], speed, end: digits(end), size: digits(size), near: { size: digits(near), within } }));
  }
}
