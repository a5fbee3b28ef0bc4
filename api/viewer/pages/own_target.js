// A mesh or a scan of the reader's own as the target: upload, what is in it, what its parts are, where it is hit; then the scene of it.

import { getJson, upload } from "../api.js";
import { button, checkbox, html, select, table } from "../dom.js";
import { bytes, number, setting } from "../format.js";
import { FIXED, GIVEN, OMITTED, STIFF, boxAround, cropFor, cutEnds, guessOf, isScan, ownScene, sizeWithin, tissueOf } from "../scene/own_scene.js";
import { PROJECTILES, rigidBall } from "../scene/projectiles.js";
import { NumberField } from "./number_field.js";
import { problemWords } from "./scene_form.js";

const ACCEPT = ".msh,.inp,.vtu,.vtk,.k,.key,.dyn,.feb,.bdf,.nas,.nii,.gz,.nrrd,.mha";
/** Nastran files have no certain beginning. */
const FORMAT_BY_NAME = /\.(bdf|nas)$/i;
const WAYS = [["0,0,-1", "from above (−z)"], ["0,0,1", "from below (+z)"], ["0,-1,0", "from the front (−y)"], ["0,1,0", "from behind (+y)"], ["-1,0,0", "from the right (−x)"], ["1,0,0", "from the left (+x)"]];
const UNITS = [[1e-3, "mm"], [1e-2, "cm"], [1, "m"]];
const OWN_BALL = "own";
/** Where a scene has what a field says. */
const PLACES = [
  [/segmentation\/crop/, "crop"], [/segmentation\/near/, "near"], [/segmentation\/skin_thickness_m$/, "skin"], [/segmentation(\/size_m)?$/, "size"],
  [/^\/end_time_s$/, "end"], [/\/velocity_m_per_s/, "speed"], [/\/rigid\/mass_kg$/, "mass"], [/\/rigid\/shape/, "diameter"], [/\/rigid\/center_m/, "point"],
];
/** Rest after the last key before the service is asked where the ball touches [ms]. */
const REST = 300;
/** Elements at the impact against those of the whole scan [-]. */
const FINER = 0.5;

/** Lengths of a box, of a mesh with this factor on its lengths. */
const millimetres = ([low, high], factor = 1) => high.map((end, k) => setting(Number((1e3 * factor * (end - low[k])).toPrecision(3)))).join(" × ");

/** The way across a body that is longest along z: its ends are where a scan or a model was cut. */
const acrossLongest = ([low, high]) => (high[2] - low[2] > Math.max(high[0] - low[0], high[1] - low[1]) ? WAYS[2][0] : WAYS[0][0]);

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
    const scale = scan ? 1 : tissue.placement?.scale ?? 1;
    this.#chosen = { id: mesh.id, file: file.name, name: file.name.replace(/\.(nii\.gz|[^.]*)$/i, ""), first, uses, held, projectile: PROJECTILES.at(-1), way: acrossLongest(boxAround(first.parts)), through: null, scale, guessed: scale, skin: materials.find(({ name }) => name.startsWith("skin/"))?.name };
    const choices = new Map(names.map((name) => [name, this.#use(name, materials, scan)]));
    this.#showParts = () => {
      const factor = this.#chosen.scale / scale;
      this.#state.textContent = [
        `${file.name}: ${bytes(mesh.bytes)}, ${mesh.elements} ${scan ? "voxels with labels" : `elements, ${mesh.nodes} nodes`}`,
        `box ${millimetres(boxAround(first.parts), factor)} mm`, ...mesh.notes.filter((note) => !note.startsWith("label ")),
      ].join("; ");
      const rows = names.map((name) => {
        const own = first.parts.filter(({ part }) => part === name);
        const volume = own.reduce((sum, { volume_m3 }) => sum + volume_m3, 0);
        return [name, choices.get(name), number(1e6 * factor ** 3 * volume, 3), millimetres(boxAround(own), factor)];
      });
      this.#parts.replaceChildren(table(`${scan ? "Labels" : "Parts"}, and what they are`, [scan ? "label" : "part", "what it is", "volume [cm³]", "box [mm]"], rows));
    };
    this.#fields = this.#newFields();
    const { diameter, mass, speed, point, end, crop, size, near, skin } = this.#fields;
    const known = UNITS.some(([unit]) => unit === scale) ? UNITS : [[scale, "as the file says"], ...UNITS];
    const unit = select("Unit of the file", known.map(([unit, words]) => [String(unit), words]), String(scale), (unit) => this.#takeUnit(Number(unit)));
    unit.append(html("small", { class: "quiet" }, "Guessed from the size of the body: few files state one."));
    this.#cropped = checkbox("only a box around the impact", false, () => this.#takeCrop(true));
    const choice = [
      select("What hits?", [...PROJECTILES.map(({ id, name }) => [id, name]), [OWN_BALL, "a rigid ball of my own"]], this.#chosen.projectile.id, (id) => this.#takeProjectile(id)),
      diameter.element, mass.element,
      select("From where?", WAYS, this.#chosen.way, (way) => ((this.#chosen.way = way), this.#aim())),
      speed.element, point.element, end.element,
      select("Accuracy", [["own", "elements as given"], ["refined", "refined until errors are below 10 %"]], "own", (choice) => (this.#chosen.accuracy = choice === "refined" ? this.#accuracy : null)),
    ];
    const ofScan = [html("div", { class: "field" }, html("span", {}, "What of the scan?"), this.#cropped), crop.element, size.element, near.element, skin.element];
    this.#contents.replaceChildren(
      this.#parts, html("div", { class: "form-grid" }, choice, scan ? "" : unit), scan ? html("div", { class: "form-grid" }, ofScan) : "", this.#holds,
      html("div", { class: "tools" }, button("Use it as the target", () => this.#make(), { class: "primary" }), this.#verdict),
    );
    this.#showParts();
    this.#takeProjectile(this.#chosen.projectile.id);
  }

  #newFields() {
    const own = { onchange: () => this.#takeProjectile(OWN_BALL) };
    return {
      diameter: new NumberField("Diameter [mm]", { value: "40", ...own }),
      mass: new NumberField("Mass [g]", { value: "100", ...own }),
      speed: new NumberField("Speed [m/s]", { value: "10" }),
      point: new NumberField("Point of impact [mm]", { axes: ["x", "y", "z"], onchange: () => this.#takePoint() }),
      end: new NumberField("Time to simulate [ms]", { value: "5" }),
      crop: new NumberField("Lengths of the box [mm]", { axes: ["x", "y", "z"], about: "Centred on the point of impact. Hold what it cuts, or it moves freely there.", onchange: () => this.#takeCrop(true) }),
      size: new NumberField("Size of the elements [mm]"),
      near: new NumberField("Size at the impact [mm]"),
      skin: new NumberField("Thickness of the skin [mm]", { about: "Where the scan does not resolve it: 1 to 3 mm. Empty: as labelled." }),
    };
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

  /** The sets that can hold the body; of a scan the ends where it is cut. */
  #showSets() {
    const { first, held, crop } = this.#chosen;
    const sets = isScan(tissueOf(first.scene)) ? cutEnds(first, crop) : first.sets;
    for (const set of held) if (!sets.includes(set)) held.delete(set);
    const hold = (set) => checkbox(set, held.has(set), (isHeld) => (isHeld ? held.add(set) : held.delete(set)));
    this.#holds.replaceChildren(html("legend", {}, "Held without motion at"), ...sets.map(hold));
    this.#holds.hidden = !sets.length;
  }

  #fields = null;
  /** Fields that the service refuses. */
  #refused = [];
  #cropped = null;
  #showParts = null;
  #parts = html("div");
  #holds = html("fieldset", { class: "held" });
  #verdict = html("span", { "aria-live": "polite", class: "field-error" });

  /** Lengths of a mesh in the unit that the reader says. */
  #takeUnit(scale) {
    this.#chosen.scale = scale;
    this.#showParts();
    this.#aim();
  }

  /** The box of the scan that is used, and sizes of elements that fit it; `isChosen` by the reader. */
  #takeCrop(isChosen = false) {
    const chosen = this.#chosen;
    const segmentation = tissueOf(chosen.first.scene).mesh.segmentation;
    if (!segmentation || !chosen.projectile) return;
    const { crop, size, near } = this.#fields;
    const box = this.#cropped.querySelector("input");
    const proposed = cropFor(chosen.projectile, segmentation);
    if (isChosen) chosen.isCropChosen = true;
    if (!chosen.isCropChosen) box.checked = proposed.isNeeded;
    crop.suggest(...proposed.size_m.map((length) => 1e3 * length));
    crop.element.hidden = !box.checked;
    const lengths = crop.numbers.map((length) => 1e-3 * length);
    chosen.crop = box.checked && chosen.touch && lengths.every((length) => length > 0) ? { center_m: chosen.touch.point_m, size_m: lengths } : null;
    const edge = sizeWithin(chosen.first, chosen.crop);
    size.suggest(1e3 * edge);
    near.suggest(Number((1e3 * FINER * edge).toPrecision(2)));
    this.#showSets();
  }

  #takeProjectile(id) {
    const known = PROJECTILES.find((one) => one.id === id);
    const { diameter, mass } = this.#fields;
    if (known) [diameter, mass].forEach((field, k) => field.put([known.diameter_mm, known.mass_g][k]));
    for (const field of [diameter, mass]) field.disabled = Boolean(known);
    this.#chosen.projectile = known ?? (diameter.number > 0 && mass.number > 0 ? rigidBall(diameter.number, mass.number) : null);
    this.#aim();
  }

  #takePoint() {
    const point = this.#fields.point.numbers.map((x) => 1e-3 * x);
    this.#chosen.through = point.every(Number.isFinite) ? point : null;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#aim(), REST);
  }

  /** Asks the service where the ball touches the target on its way: in the unit that the service takes the file to be in. */
  async #aim() {
    const chosen = this.#chosen;
    const asked = ++this.#aimed;
    chosen.touch = null;
    this.#verdict.textContent = "";
    if (!chosen.projectile) return;
    const factor = chosen.scale / chosen.guessed;
    const through = chosen.through ? `&through_m=${chosen.through.map((x) => x / factor).join(",")}` : "";
    try {
      const { touches } = await getJson(`/v1/meshes/${chosen.id}/first-scene?radius_m=${chosen.projectile.diameter_mm / 2e3 / factor}${through}`);
      if (asked !== this.#aimed) return;
      const touch = touches.find(({ direction }) => direction.join(",") === chosen.way);
      const scaled = (point) => point.map((x) => x * factor);
      if (!touch) this.#verdict.textContent = "On this way the ball misses: choose another point, or come from elsewhere.";
      else {
        chosen.touch = { ...touch, point_m: scaled(touch.point_m), center_m: scaled(touch.center_m) };
        if (!chosen.through) this.#fields.point.put(...chosen.touch.point_m.map((x) => Number((1e3 * x).toFixed(2))));
      }
      isScan(tissueOf(chosen.first.scene)) ? this.#takeCrop() : this.#showSets();
    } catch (error) {
      if (asked === this.#aimed) this.#verdict.textContent = error.message;
    }
  }

  /** Hands the scene over, or says what is missing. */
  async #make() {
    // Of what stands there now, however recently it was typed.
    clearTimeout(this.#timer);
    await this.#aim();
    const { uses, held, touch, scale } = this.#chosen;
    const scan = isScan(tissueOf(this.#chosen.first.scene));
    const { speed, end, size, near, crop, skin } = this.#fields;
    const isCropped = scan && !crop.element.hidden;
    const asked = [[speed, "a speed"], [end, "a time"], ...(scan ? [[size, "the size of elements"], [near, "their size at the impact"]] : []), ...(isCropped ? [[crop, "lengths of the box"]] : []), ...(scan && !skin.isEmpty ? [[skin, "the thickness of the skin, or nothing"]] : [])];
    const wrong = asked.filter(([field]) => !field.numbers.every((x) => x > 0));
    for (const [field] of wrong) field.mark("This has to be above 0.");
    const miss = this.#verdict.textContent;
    const missing = [...[...uses].filter(([, use]) => !use).map(([name]) => `what ${name} is`), ...(touch ? [] : ["a place where it touches"]), ...wrong.map(([, words]) => words)];
    this.#verdict.textContent = missing.length ? `Still missing: ${missing.join(", ")}. ${miss}` : "";
    if (missing.length) return;
    const metres = (field) => Number((1e-3 * field.number).toPrecision(6));
    const within = this.#chosen.projectile.diameter_mm / 4e3;
    const skinned = scan && !skin.isEmpty ? { skin: { thickness: metres(skin), material: this.#chosen.skin } } : { skin: null };
    this.#onScene(ownScene({ ...this.#chosen, ...skinned, held: [...held], speed: speed.number, end: metres(end), size: metres(size), near: { size: metres(near), within }, scale: scan ? 1 : scale }));
  }

  /** Marks the fields whose numbers the service refuses in a scene of this file. */
  showProblems(scene, problems) {
    for (const field of this.#refused.splice(0)) field.mark("");
    const isOwn = (body) => [body?.mesh?.file?.name, body?.mesh?.segmentation?.name].includes(this.#chosen?.id);
    if (!this.#chosen || !Array.isArray(scene?.bodies) || !scene.bodies.some(isOwn)) return;
    for (const problem of problems) {
      const field = this.#fields[PLACES.find(([pattern]) => pattern.test(problem.pointer))?.[1]];
      field?.mark(problemWords(problem));
      if (field) this.#refused.push(field);
    }
  }
}
