// The section of a body with a plane: coloured triangles, the outlines of its elements, of its parts and of itself.

import { SIDE, areAround, distancesAlong } from "./cells.js";

/** Edges of a tetrahedron, and of a side by the number of nodes around it: pairs of corners, one after the other. */
const EDGES = [0, 1, 0, 2, 0, 3, 1, 2, 1, 3, 2, 3];
const AROUND = { 3: [0, 1, 1, 2, 2, 0], 4: [0, 1, 1, 2, 2, 3, 3, 0], 6: [0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 0] };
/** Triangles of three or four cut edges: of a quadrilateral the order of the edges makes 0, 1, 3, 2 go around. */
const ORDER = { 3: [0, 1, 2], 4: [0, 1, 3, 0, 3, 2] };

/** A section with nothing in it. */
export const NO_SECTION = {
  positions: new Float32Array(0), values: new Float32Array(0), lines: new Float32Array(0), outlines: new Float32Array(0),
  elements: new Uint32Array(0), ends: new Uint32Array(0), fractions: new Float32Array(0),
};

/**
 * The section with the plane n·x = d. `sides` is what each side of each element is ([`surfaceOf`]). In the answer `positions`, `values`
 * are of the corners of triangles, `elements` of the triangles; `ends` and `fractions` give each corner as a place between two nodes;
 * `lines` are the outlines of elements, `outlines` those of parts and of the body.
 */
export function planeSection({ cells, sides, positions, values, normal, offset, eroded = null }) {
  const heights = distancesAlong(positions, normal, offset);
  const [corners, elements, lines, outlines] = [[], [], [], []];
  for (let e = 0, side = 0; e < cells.length; e++) {
    const { sides: faces, tetrahedra } = cells.kindOf(e);
    const firstSide = side;
    side += faces.length;
    if (eroded?.[e] || !areAround(heights, cells, e)) continue;
    const nodes = cells.nodesOf(e);
    for (const tetrahedron of tetrahedra) {
      const cut = cutEdges(heights, nodes, tetrahedron, EDGES);
      if (!cut.length) continue;
      for (const p of ORDER[cut.length / 2]) corners.push(cut[2 * p], cut[2 * p + 1]);
      while (elements.length < corners.length / 6) elements.push(e);
    }
    faces.forEach((face, s) => {
      const cut = cutEdges(heights, nodes, face, AROUND[face.length]);
      if (cut.length === 4) (sides[firstSide + s] === SIDE.inside ? lines : outlines).push(...cut);
    });
  }
  const [ends, fractions] = [new Uint32Array(corners), fractionsOf(corners, heights)];
  const placesOf = (list) => between(positions, 3, list, fractionsOf(list, heights));
  return {
    positions: between(positions, 3, ends, fractions), values: values ? between(values, 1, ends, fractions) : new Float32Array(fractions.length),
    elements: new Uint32Array(elements), ends, fractions, lines: placesOf(lines), outlines: placesOf(outlines),
  };
}

const NONE = [];

/** Edges between `corners` of an element that cross the plane, as pairs of nodes. */
function cutEdges(heights, nodes, corners, edges) {
  let found = NONE;
  for (let k = 0; k < edges.length; k += 2) {
    const i = nodes[corners[edges[k]]];
    const j = nodes[corners[edges[k + 1]]];
    if (heights[i] > 0 === heights[j] > 0) continue;
    if (found === NONE) found = [];
    found.push(i, j);
  }
  return found;
}

/** Where the plane crosses edges: fractions of the way from their first to their second node. */
function fractionsOf(ends, heights) {
  const fractions = new Float32Array(ends.length / 2);
  for (let c = 0; c < fractions.length; c++) fractions[c] = heights[ends[2 * c]] / (heights[ends[2 * c]] - heights[ends[2 * c + 1]]);
  return fractions;
}

/** Values of nodes, `stride` each, between the two ends of each corner. */
function between(values, stride, ends, fractions) {
  const found = new Float32Array(stride * fractions.length);
  for (let c = 0; c < fractions.length; c++) {
    const [a, b] = [stride * ends[2 * c], stride * ends[2 * c + 1]];
    for (let k = 0; k < stride; k++) found[stride * c + k] = values[a + k] + fractions[c] * (values[b + k] - values[a + k]);
  }
  return found;
}
