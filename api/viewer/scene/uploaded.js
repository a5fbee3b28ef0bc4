// Sections of the uploaded meshes of a scene: which of them a picture needs, and the shapes that they are there.

import { getJson } from "../api.js";

const ID = /^[0-9a-f]{64}$/;
const AXES = ["x", "y", "z"];
/** Rest after the last change before the service is asked [ms]. */
const REST = 350;
/** Sections that are kept. */
const MOST_KEPT = 30;

/** The uploaded mesh of a body: its id, and its placement if that keeps its axes; null for other bodies. */
export function uploadedIn(body) {
  const id = body?.mesh?.file?.name ?? body?.mesh?.segmentation?.name;
  const { scale = 1, translation_m: translation = [0, 0, 0], ...turned } = body?.placement ?? {};
  return ID.test(id ?? "") && scale > 0 && !Object.keys(turned).length ? { id, scale, translation } : null;
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

  /** The sections of meshes, [{id, scale, translation}], across an axis at a place [m]; undefined for those that are still asked for. */
  at(meshes, axis, place) {
    const addresses = meshes.map(({ id, scale, translation }) => `/v1/meshes/${id}/section?normal=${AXES[axis]}&at=${Number(((place - translation[axis]) / scale).toPrecision(6))}`);
    const missing = [...new Set(addresses)].filter((address) => !this.#known.has(address));
    clearTimeout(this.#timer);
    if (missing.length) this.#timer = setTimeout(() => this.#ask(missing), REST);
    return addresses.map((address) => this.#known.get(address));
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

/** The outlines of the parts of a body in its section, by the name that they have in the scene: [{name, isHole, lines}], lines in metres. */
export function outlinesOf(body, section, across) {
  const { scale, translation } = uploadedIn(body);
  const { segmentation, file } = body.mesh;
  const listed = segmentation?.labels && new Map(segmentation.labels.map((entry) => [entry.label, entry]));
  const usage = ({ part, label }) => (listed ? listed.get(label) ?? {} : file?.parts && !file.parts.includes(part) ? {} : { part });
  const placed = (line) => line.map(([u, v]) => [u * scale + translation[across], v * scale + translation[2]]);
  return section.parts.flatMap((cut) => {
    const { part, hole } = usage(cut);
    return part || hole ? [{ name: part ?? hole, isHole: !part, lines: cut.outlines.map(placed) }] : [];
  });
}

/** The part of the plane that a crop keeps [m], or null: corners [[u, v], [u, v]]. */
export function cropOf(body, across) {
  const { crop } = body.mesh.segmentation ?? {};
  if (!crop) return null;
  const { scale, translation } = uploadedIn(body);
  return [-0.5, 0.5].map((side) => [across, 2].map((k) => (crop.center_m[k] + side * crop.size_m[k]) * scale + translation[k]));
}
