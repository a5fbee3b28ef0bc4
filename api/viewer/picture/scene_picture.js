// The bodies of a scene in space before anything runs, as the service would begin with them: layers in their colours, and the velocity of
// the projectile as an arrow.

import { html } from "../dom.js";
import { setting } from "../format.js";
import { boneOf } from "../mesh/bone.js";
import { Cells, boxAround } from "../mesh/cells.js";
import { MeshView } from "../mesh/mesh_view.js";
import { colourOfPart } from "../mesh/part_colours.js";
import { ViewSettings, cameraButtons } from "./view_settings.js";

/** What is looked at first is larger than in the picture of a run, whose projectile is in the tissue [-]. */
const WIDER = 1.5;
/** Length of the arrow, and its distance from the centre of what flies, in radii of that [-]. */
const [LENGTH, AWAY] = [1.7, 1.15];

/** A body as pictures take it, from the answer of the service and its part of the document. */
function bodyOf({ body: name, positions_m: positions, cell_types: types, cell_nodes: nodes, parts, part_of: partOf, triangles }, document) {
  const { role } = document;
  const points = Float32Array.from(positions);
  if (triangles.length) return { name, role, surface: { points, triangles: Uint32Array.from(triangles) }, rest: { pose: { position: [0, 0, 0], orientation: [0, 0, 0, 1] } } };
  const cells = new Cells(Uint32Array.from(nodes), Uint8Array.from(types));
  return { name, role, parts, X: Float64Array.from(positions), V: [0, 0, 0], cells, types, partOf, rest: { positions: points, fields: {} } };
}

/** The parts of a body as bodies of their own: each has one colour, and an outline where it is cut. */
function partsOf(body, document) {
  if (!body.cells) return [{ ...body, colour: colourOfPart(document) }];
  return body.parts.map((part, p) => {
    const [nodes, types] = [[], []];
    for (let e = 0; e < body.cells.length; e++) {
      if (body.partOf[e] !== p) continue;
      types.push(body.types[e]);
      nodes.push(...body.cells.nodesOf(e));
    }
    const cells = new Cells(Uint32Array.from(nodes), Uint8Array.from(types));
    const name = body.parts.length > 1 ? part : body.name;
    return { ...body, name: `${body.name} ${part}`, parts: [name], cells, partOf: new Uint32Array(types.length), colour: colourOfPart(document, part) };
  });
}

export class ScenePicture {
  element = html("div", { class: "scene-picture" });
  #note = html("p", { class: "quiet" });
  #view = null;
  #settings = null;
  #names = "";

  /** Shows bodies as the service answers them, with their scene document; a view that the reader has turned stays as long as the bodies do. */
  show(geometry, scene) {
    const documentOf = ({ body }) => scene.bodies.find(({ name }) => name === body) ?? {};
    const bodies = new Map(geometry.map((one) => [one.body, bodyOf(one, documentOf(one))]));
    const deformable = [...bodies.values()].filter(({ cells }) => cells);
    const tissue = deformable.find(({ role }) => role === "tissue") ?? deformable[0];
    const begins = new Map([...bodies.values()].map(({ name, rest, surface }) => [name, surface ? { pose: { position: middleOf(surface.points) } } : rest]));
    const shown = geometry.flatMap((one) => partsOf(bodies.get(one.body), documentOf(one)));
    const bone = boneOf(scene);
    if (bone) shown.push(bone);
    // As a recording in which nothing has happened yet: the cut and the camera are those of its picture.
    const recording = { bodies, drawn: bodies, tissue, scene, frames: [{ time: 0, bodies: begins, contacts: null }], series: { pairs: new Map() } };
    this.#settings = new ViewSettings([recording], [], () => {});
    this.#draw(shown, flying(bodies, scene));
    const names = [...bodies.keys()].join("\n");
    if (names !== this.#names || !this.#view.isMoved) this.#look(false);
    this.#names = names;
  }

  #draw(shown, arrows) {
    this.#view ??= this.#newView();
    this.#view.setBodies(new Map(shown.map((body) => [body.name, body])));
    this.#view.setArrows(arrows.map(({ from, to }) => [from, to]));
    this.#view.setLine(this.#settings.line, this.#settings.depth);
    this.#view.show({ bodies: new Map() }, () => null, this.#settings.cut);
    const speeds = arrows.map(({ name, speed }) => `${name} at ${setting(Number(speed.toPrecision(4)))} m/s`);
    this.#note.textContent = [speeds.length && `Arrow: velocity of ${speeds.join(", ")}.`, this.#settings.cut && "Cut through the impact.", "Drag to turn, scroll to zoom."].filter(Boolean).join(" ");
  }

  #newView() {
    const view = new MeshView("The bodies of the scene before the impact");
    view.probe = ({ name, part }) => part ?? name;
    view.corner.append(...cameraButtons((isWhole) => this.#look(isWhole)));
    this.element.replaceChildren(view.element, this.#note);
    return view;
  }

  #look(isWhole) {
    const { line } = this.#settings;
    const camera = this.#settings.camera(isWhole);
    this.#view.lookAt(isWhole || !line ? camera : { ...camera, centre: camera.isGrown ? camera.centre : line.centre, radius: WIDER * camera.radius });
  }

  leave() {
    this.#view?.dispose();
  }
}

/** The middle of the box around points. */
function middleOf(points) {
  const { low, high } = boxAround(points);
  return low.map((l, k) => (l + high[k]) / 2);
}

/** Arrows to the bodies that fly, from where they come: {name, speed [m/s], from, to}. */
function flying(bodies, scene) {
  return scene.bodies.flatMap(({ name, velocity_m_per_s: velocity = [0, 0, 0] }) => {
    const [body, speed] = [bodies.get(name), Math.hypot(...velocity)];
    if (!body || !(speed > 0)) return [];
    const { low, high } = boxAround(body.X ?? body.surface.points);
    const radius = 0.5 * Math.max(...low.map((l, k) => high[k] - l));
    const behind = (radii) => low.map((l, k) => (l + high[k]) / 2 - (radii * radius * velocity[k]) / speed);
    return [{ name, speed, from: behind(AWAY + LENGTH), to: behind(AWAY) }];
  });
}
