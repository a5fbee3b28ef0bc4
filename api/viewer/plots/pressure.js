// The pressure of a contact at the nodes of the touching surface, and the surface in the plane of the patch.

import { surfaceOf } from "../mesh/cells.js";
import { cross, dot, flatPatch } from "./flat_patch.js";

/** Of the touching area this fraction has no more than the high pressure of patches: above are spots at corners of the mesh [-]. */
export const HIGH = 0.95;

/** The pressure [Pa] that the fraction `HIGH` of the area of some nodes {pressure, area} is not above; 0 of none. */
export function highPressure(nodes) {
  const ascending = nodes.filter(({ area }) => area > 0).sort((a, b) => a.pressure - b.pressure);
  let left = HIGH * ascending.reduce((sum, { area }) => sum + area, 0);
  return ascending.find(({ area }) => (left -= area) <= 0)?.pressure ?? ascending.at(-1)?.pressure ?? 0;
}

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

export class ContactSurface {
  #recording;

  constructor(recording) {
    this.#recording = recording;
  }

  /**
   * The patch of a pair in a frame: that of [`flatPatch`] with `facets`, triangles of {x, y [m], pressure [Pa]} with a touching corner,
   * and its `nodes` {pressure [Pa], area [m²]}; none where the touching body has no mesh. A node's pressure is its force over its area, a
   * third of that of the facets around it.
   */
  patch(frame, contacts) {
    const patch = flatPatch(contacts);
    const { positions, eroded } = frame.bodies.get(contacts?.slave) ?? {};
    const body = this.#recording.bodies.get(contacts?.slave);
    if (!patch || !body?.cells || !positions) return patch && { ...patch, facets: [], nodes: [] };
    const { triangles } = surfaceOf(body, eroded);
    const forces = new Map();
    for (const { node, force } of patch.points) forces.set(node, (forces.get(node) ?? 0) + force);
    const at = (node) => [positions[3 * node], positions[3 * node + 1], positions[3 * node + 2]];
    const areas = new Map();
    const touching = [];
    for (let t = 0; t < triangles.length; t += 3) {
      const nodes = [triangles[t], triangles[t + 1], triangles[t + 2]];
      if (!nodes.some((node) => forces.has(node))) continue;
      touching.push(nodes);
      const [a, b, c] = nodes.map(at);
      const area = 0.5 * Math.hypot(...cross(minus(b, a), minus(c, a)));
      for (const node of nodes) areas.set(node, (areas.get(node) ?? 0) + area / 3);
    }
    const pressureOf = (node) => (forces.get(node) ?? 0) / (areas.get(node) || Infinity);
    const corner = (node) => {
      const arm = minus(at(node), patch.centre);
      return { x: dot(arm, patch.axes[0]), y: dot(arm, patch.axes[1]), pressure: pressureOf(node) };
    };
    const facets = touching.map((nodes) => nodes.map(corner));
    return { ...patch, facets, nodes: [...forces.keys()].map((node) => ({ pressure: pressureOf(node), area: areas.get(node) ?? 0 })) };
  }
}
