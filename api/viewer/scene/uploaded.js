// Sections of the uploaded meshes of a scene: which of them a picture needs, and the shapes that they are there.

import { getJson } from "../api.js";

const ID = /^[0-9a-f]{64}$/;
const AXES = ["x", "y", "z"];
/** Rest after the last change before the service is asked [ms]. */
const REST = 350;
/** Sections that are kept. */
const MOST_KEPT = 30;

/** The files that the mesh of a body is made of, with the scale of each. */
export function filesOf(body) {
  const { file, segmentation } = body?.mesh ?? {};
  const surfaces = Array.isArray(segmentation?.surfaces) ? segmentation.surfaces : [];
  const whole = file?.name ?? segmentation?.name;
  return [...(whole ? [{ name: whole, scale: 1 }] : []), ...surfaces.map((surface) => ({ name: surface?.name, scale: surface?.scale ?? 1 }))];
}

/** The uploads that a body is made of: their ids, and their placement if that keeps its axes; none for other bodies. */
export function uploadedIn(body) {
  const { scale = 1, translation_m: translation = [0, 0, 0], ...turned } = body?.placement ?? {};
  const uploads = filesOf(body).map(({ name, scale: own }) => ({ id: name, scale: scale * own, translation }));
  return uploads.every((upload) => ID.test(upload.id ?? "") && upload.scale > 0) && !Object.keys(turned).length ? uploads : [];
}

/** Sections as the service cuts them, asked for once each. */
export class Sections {
  #known = new Map();
  #timer = null;
  #onAnswer;

  /** `onAnswer()` after sections have come that were not there before. */
  constructor(onAnswer) {
    this.#onAnswer = onAnswer;
  }

  leave() {
    clearTimeout(this.#timer);
  }

  /** The sections of the uploads of each body, [{id, scale, translation}], across an axis at a place [m]; undefined for those that are still asked for. */
  at(bodies, axis, place) {
    const addressOf = ({ id, scale, translation }) => `/v1/meshes/${id}/section?normal=${AXES[axis]}&at=${Number(((place - translation[axis]) / scale).toPrecision(6))}`;
    const missing = [...new Set(bodies.flat().map(addressOf))].filter((address) => !this.#known.has(address));
    clearTimeout(this.#timer);
    if (missing.length) this.#timer = setTimeout(() => this.#ask(missing), REST);
    return bodies.map((uploads) => uploads.map((upload) => this.#known.get(addressOf(upload))));
  }

  async #ask(addresses) {
    await Promise.all(addresses.map(async (address) => {
      // What cannot be cut is said as such in place of a section.
      const section = await getJson(address).catch((error) => ({ refused: error.message }));
      this.#known.set(address, section);
    }));
    for (const address of [...this.#known.keys()].slice(0, -MOST_KEPT)) this.#known.delete(address);
    this.#onAnswer();
  }
}

/** The outlines of the parts of a body in its sections, by the name that they have in the scene: [{name, isHole, lines}], lines in metres. */
export function outlinesOf(body, sections, across) {
  const { segmentation, file } = body.mesh;
  const listed = segmentation?.labels && new Map(segmentation.labels.map((entry) => [entry.label, entry]));
  const usage = ({ part, label }, n) => segmentation?.surfaces?.[n] ?? (listed ? listed.get(label) ?? {} : file?.parts && !file.parts.includes(part) ? {} : { part });
  return uploadedIn(body).flatMap(({ scale, translation }, n) => {
    const placed = (line) => line.map(([u, v]) => [u * scale + translation[across], v * scale + translation[2]]);
    return sections[n].parts.flatMap((cut) => {
      const { part, hole } = usage(cut, n);
      return part || hole ? [{ name: part ?? hole, isHole: !part, lines: cut.outlines.map(placed) }] : [];
    });
  });
}

/** The part of the plane that a crop keeps [m], or null: corners [[u, v], [u, v]]. */
export function cropOf(body, across) {
  const { crop } = body.mesh.segmentation ?? {};
  if (!crop) return null;
  const { scale = 1, translation_m: translation = [0, 0, 0] } = body.placement ?? {};
  return [-0.5, 0.5].map((side) => [across, 2].map((k) => (crop.center_m[k] + side * crop.size_m[k]) * scale + translation[k]));
}
