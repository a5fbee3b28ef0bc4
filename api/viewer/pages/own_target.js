// A mesh, a scan or closed surfaces of the reader's own as the target: upload, what is in it, what its parts are, where it is hit; then the scene of it.

import { getJson, upload } from "../api.js";
import { button, checkbox, html, select, table } from "../dom.js";
import { bytes, number, setting } from "../format.js";
import { FIXED, GIVEN, OMITTED, STIFF, boxAround, cropFor, cutEnds, guessOf, isFilled, ownScene, scaledBy, sizeWithin, tissueOf } from "../scene/own_scene.js";
import { PROJECTILES, rigidBall } from "../scene/projectiles.js";
import { filesOf } from "../scene/uploaded.js";
import { NumberField } from "./number_field.js";
import { problemWords } from "./scene_form.js";

const ACCEPT = ".msh,.inp,.vtu,.vtk,.k,.key,.dyn,.feb,.bdf,.nas,.nii,.gz,.nrrd,.mha,.mhd,.stl";
/** Nastran files have no certain beginning. */
const FORMAT_BY_NAME = /\.(bdf|nas)$/i;
const SURFACE = /\.stl$/i;
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

const millimetres = ([low, high]) => high.map((end, k) => setting(Number((1e3 * (end - low[k])).toPrecision(3)))).join(" × ");

/** Where the service begins a scene of uploads: the names of surfaces say what they are. */
const beginning = ([mesh, ...others], [file, ...more]) => {
  const named = others.map(({ id }, i) => `${id}:${encodeURIComponent(more[i].name)}`);
  return `/v1/meshes/${mesh.id}/first-scene?${SURFACE.test(file.name) ? `name=${encodeURIComponent(file.name)}&with=${named.join("/")}&` : ""}`;
};

/** The way across a body that is longest along z: its ends are where a scan or a model was cut. */
const acrossLongest = ([low, high]) => (high[2] - low[2] > Math.max(high[0] - low[0], high[1] - low[1]) ? WAYS[2][0] : WAYS[0][0]);

export class OwnTarget {
  #onScene;
  #accuracy;
  #leaving = new AbortController();
  #file = html("input", { type: "file", accept: ACCEPT, multiple: true, onchange: () => this.#take([...this.#file.files]) });
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
    this.element = html("details", { class: "panel own-target" }, html("summary", {}, "Start from your own mesh or scan"),
      html("label", { class: "field" }, html("span", {}, "Mesh (.msh, .inp, .vtu, .vtk, .k, .feb, .bdf), scan with labels (.nii, .nii.gz, .nrrd, .mha), or nested closed surfaces (several .stl)"), this.#file),
      this.#bar, this.#state, this.#contents);
  }

  leave() {
    clearTimeout(this.#timer);
    this.#leaving.abort();
  }

  /** Uploads files and shows what the service finds in them. */
  async #take(files) {
    if (!files.length) return;
    const names = files.map(({ name }) => name).join(", ");
    const asked = ++this.#asked;
    this.#leaving.abort();
    const { signal } = (this.#leaving = new AbortController());
    this.#contents.replaceChildren();
    this.#bar.hidden = false;
    const sent = (file, part) => {
      this.#bar.value = (files.indexOf(file) + part) / files.length;
      this.#state.textContent = part < 1 ? `Sending ${file.name}: ${Math.round(100 * part)} %` : `The service reads ${file.name} …`;
    };
    try {
      if (files.length > 1 && !files.every(({ name }) => SURFACE.test(name))) throw new Error("choose one file, or several closed surfaces (.stl)");
      const meshes = [];
      for (const file of files) {
        sent(file, 0);
        const format = FORMAT_BY_NAME.test(file.name) ? "?format=bdf" : "";
        meshes.push(await upload(`/v1/meshes${format}`, file, (part) => sent(file, part), signal).catch((error) => {
          throw Object.assign(error, { file: file.name });
        }));
      }
      const address = beginning(meshes, files);
      const [first, materials] = await Promise.all([getJson(address), getJson("/v1/materials")]);
      if (asked === this.#asked) this.#show({ names, address, id: meshes[0].id }, meshes, first, materials);
    } catch (error) {
      if (asked === this.#asked && !signal.aborted) this.#refuse(error.file ?? names, error);
    } finally {
      if (asked === this.#asked) this.#bar.hidden = true;
    }
  }

  #refuse(name, error) {
    const words = [error.message, error.body?.remedy].filter(Boolean).join(" ");
    this.#state.replaceChildren(html("p", { class: "alert", role: "alert" }, `${name} cannot be used: ${words}`));
  }

  /** Shows the parts of uploads, {names, address, id}, and what is to be chosen. */
  #show(uploads, meshes, first, materials) {
    const tissue = tissueOf(first.scene);
    const filled = isFilled(tissue);
    const surfaces = tissue.mesh.segmentation?.surfaces;
    const names = [...new Set(first.parts.map(({ part }) => part))];
    const uses = new Map(names.map((name) => [name, guessOf(first.scene, name)]));
    const held = new Set((tissue.fixed ?? []).map(({ set }) => set).filter((set) => first.sets.includes(set)));
    const scale = (surfaces?.[0] ?? tissue.placement)?.scale ?? 1;
    const name = surfaces ? first.scene.name : uploads.names.replace(/\.(nii\.gz|[^.]*)$/i, "");
    this.#chosen = { ...uploads, file: uploads.names, name, first, begun: first, factor: 1, uses, held, projectile: PROJECTILES.at(-1), way: acrossLongest(boxAround(first.parts)), through: null, skin: materials.find(({ name }) => name.startsWith("skin/"))?.name };
    const choices = new Map(names.map((name) => [name, this.#use(name, materials, filled)]));
    const sum = (key) => meshes.reduce((total, mesh) => total + mesh[key], 0);
    const [kind, ofKind] = surfaces ? ["surface", "triangles"] : filled ? ["label", "voxels with labels"] : ["part", `elements, ${sum("nodes")} nodes`];
    this.#showParts = () => {
      const { parts } = this.#chosen.first;
      const notes = surfaces ? [] : meshes[0].notes.filter((note) => !note.startsWith("label "));
      this.#state.textContent = [`${uploads.names}: ${bytes(sum("bytes"))}, ${sum("elements")} ${ofKind}`, `box ${millimetres(boxAround(parts))} mm`, ...notes].join("; ");
      const rows = names.map((name) => {
        const own = parts.filter(({ part }) => part === name);
        const volume = own.reduce((total, { volume_m3 }) => total + volume_m3, 0);
        return [name, choices.get(name), number(1e6 * volume, 3), millimetres(boxAround(own))];
      });
      this.#parts.replaceChildren(table(`${kind[0].toUpperCase()}${kind.slice(1)}s, and what they are`, [kind, "what it is", surfaces ? "encloses [cm³]" : "volume [cm³]", "box [mm]"], rows));
    };
    this.#fields = this.#newFields();
    const { diameter, mass, speed, point, end, crop, size, near, skin } = this.#fields;
    const known = UNITS.some(([unit]) => unit === scale) ? UNITS : [[scale, "as the file says"], ...UNITS];
    const unit = select("Unit of the file", known.map(([unit, words]) => [String(unit), words]), String(scale), (unit) => this.#takeUnit(Number(unit) / scale));
    unit.append(html("small", { class: "quiet" }, "Guessed from the size of the body: few files state one."));
    this.#cropped = checkbox("only a box around the impact", false, () => this.#takeCrop(true));
    const choice = [
      select("What hits?", [...PROJECTILES.map(({ id, name }) => [id, name]), [OWN_BALL, "a custom rigid ball"]], this.#chosen.projectile.id, (id) => this.#takeProjectile(id)),
      diameter.element, mass.element,
      select("From where?", WAYS, this.#chosen.way, (way) => ((this.#chosen.way = way), this.#aim())),
      speed.element, point.element, end.element,
      select("Accuracy", [["own", "elements as given"], ["refined", "refined until errors are below 10 %"]], "own", (choice) => (this.#chosen.accuracy = choice === "refined" ? this.#accuracy : null)),
    ];
    const ofFilled = [html("div", { class: "field" }, html("span", {}, "What of the body?"), this.#cropped), crop.element, size.element, near.element, skin.element];
    this.#contents.replaceChildren(
      this.#parts, html("div", { class: "form-grid" }, choice, filled && !surfaces ? "" : unit), filled ? html("div", { class: "form-grid" }, ofFilled) : "", this.#holds,
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

  #use(name, materials, filled) {
    const { uses } = this.#chosen;
    const families = Map.groupBy(materials, ({ name: set }) => set.split("/")[0]);
    const option = (value, words = value) => html("option", { value, selected: value === uses.get(name) }, words);
    const choice = html("select", { "aria-label": `What is ${name}?`, onchange: () => uses.set(name, choice.value) },
      uses.get(name) === GIVEN ? option(GIVEN, "as the file says") : option("", "not chosen yet"),
      html("optgroup", { label: "bone and outside" }, filled ? option(FIXED, "bone, rigid and fixed") : "", option(STIFF, "bone, stiff, moves"), option(OMITTED, "no part of the body")),
      [...families].map(([family, sets]) => html("optgroup", { label: family }, sets.map((set) => option(set.name)))));
    return choice;
  }

  /** The sets that can hold the body; of what is filled with elements the ends where it is cut. */
  #showSets() {
    const { first, held, crop } = this.#chosen;
    const sets = isFilled(tissueOf(first.scene)) ? cutEnds(first, crop) : first.sets;
    for (const set of held) if (!sets.includes(set)) held.delete(set);
    const hold = (set) => checkbox(set, held.has(set), (isHeld) => (isHeld ? held.add(set) : held.delete(set)));
    this.#holds.replaceChildren(html("legend", {}, "Fixed at"), ...sets.map(hold));
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

  /** Lengths in the unit that the reader says: a factor on those that the service guesses. */
  #takeUnit(factor) {
    const chosen = this.#chosen;
    Object.assign(chosen, { factor, first: scaledBy(chosen.begun, factor) });
    this.#showParts();
    this.#aim();
  }

  /** The box of the body that is used, and sizes of elements that fit it; `isChosen` by the reader. */
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
    const { factor } = chosen;
    const through = chosen.through ? `&through_m=${chosen.through.map((x) => x / factor).join(",")}` : "";
    try {
      const { touches } = await getJson(`${chosen.address}radius_m=${chosen.projectile.diameter_mm / 2e3 / factor}${through}`);
      if (asked !== this.#aimed) return;
      const touch = touches.find(({ direction }) => direction.join(",") === chosen.way);
      const scaled = (point) => point.map((x) => x * factor);
      if (!touch) this.#verdict.textContent = "In this direction the ball misses: choose another point or direction.";
      else {
        chosen.touch = { ...touch, point_m: scaled(touch.point_m), center_m: scaled(touch.center_m) };
        if (!chosen.through) this.#fields.point.put(...chosen.touch.point_m.map((x) => Number((1e3 * x).toFixed(2))));
      }
      isFilled(tissueOf(chosen.first.scene)) ? this.#takeCrop() : this.#showSets();
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
    const filled = isFilled(tissueOf(this.#chosen.first.scene));
    const { speed, end, size, near, crop, skin } = this.#fields;
    const isCropped = filled && !crop.element.hidden;
    const asked = [[speed, "a speed"], [end, "a time"], ...(filled ? [[size, "the size of elements"], [near, "their size at the impact"]] : []), ...(isCropped ? [[crop, "lengths of the box"]] : []), ...(filled && !skin.isEmpty ? [[skin, "the thickness of the skin, or nothing"]] : [])];
    const wrong = asked.filter(([field]) => !field.numbers.every((x) => x > 0));
    for (const [field] of wrong) field.mark("This must be above 0.");
    const miss = this.#verdict.textContent;
    const missing = [...[...uses].filter(([, use]) => !use).map(([name]) => `what ${name} is`), ...(touch ? [] : ["a place where it touches"]), ...wrong.map(([, words]) => words)];
    this.#verdict.textContent = missing.length ? `Still missing: ${missing.join(", ")}. ${miss}` : "";
    if (missing.length) return;
    const metres = (field) => Number((1e-3 * field.number).toPrecision(6));
    const within = this.#chosen.projectile.diameter_mm / 4e3;
    const skinned = filled && !skin.isEmpty ? { skin: { thickness: metres(skin), material: this.#chosen.skin } } : { skin: null };
    this.#onScene(ownScene({ ...this.#chosen, ...skinned, held: [...held], speed: speed.number, end: metres(end), size: metres(size), near: { size: metres(near), within } }));
  }

  /** Marks the fields whose numbers the service refuses in a scene of this file. */
  showProblems(scene, problems) {
    for (const field of this.#refused.splice(0)) field.mark("");
    const isOwn = (body) => filesOf(body).some(({ name }) => name === this.#chosen?.id);
    if (!this.#chosen || !Array.isArray(scene?.bodies) || !scene.bodies.some(isOwn)) return;
    for (const problem of problems) {
      const field = this.#fields[PLACES.find(([pattern]) => pattern.test(problem.pointer))?.[1]];
      field?.mark(problemWords(problem));
      if (field) this.#refused.push(field);
    }
  }
}
