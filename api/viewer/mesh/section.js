// The section of a body with a plane: coloured triangles, the outlines of its elements, of its parts and of itself.

import { SIDE } from "./cells.js";

const EDGES = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

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
  const found = { positions: [], values: [], elements: [], ends: [], fractions: [] };
  const [lines, outlines] = [[], []];
  const distance = (node) =>
    normal[0] * positions[3 * node] + normal[1] * positions[3 * node + 1] + normal[2] * positions[3 * node + 2] - offset;
  const heights = new Float64Array(10);
  for (let e = 0, firstSide = 0; e < cells.length; e++) {
    const [start, kind, side0] = [cells.startOf(e), cells.kindOf(e), firstSide];
    firstSide += kind.sides.length;
    if (eroded?.[e]) continue;
    let above = 0;
    for (let i = 0; i < kind.nodes; i++) above += (heights[i] = distance(cells.nodes[start + i])) > 0 ? 1 : 0;
    if (above === 0 || above === kind.nodes) continue;
    const cross = (a, b) => {
      const fraction = heights[a] / (heights[a] - heights[b]);
      const [i, j] = [cells.nodes[start + a], cells.nodes[start + b]];
      return { i, j, fraction, at: [0, 1, 2].map((k) => positions[3 * i + k] + fraction * (positions[3 * j + k] - positions[3 * i + k])) };
    };
    const isCut = ([a, b]) => heights[a] > 0 !== heights[b] > 0;
    for (const tetrahedron of kind.tetrahedra) {
      const points = EDGES.map(([a, b]) => [tetrahedron[a], tetrahedron[b]]).filter(isCut).map(([a, b]) => cross(a, b));
      addTriangles(found, points, e, values);
    }
    kind.sides.forEach((side, s) => {
      const ends = side.map((c, i) => [c, side[(i + 1) % side.length]]).filter(isCut).map(([a, b]) => cross(a, b).at);
      if (ends.length !== 2) return;
      (sides[side0 + s] === SIDE.inside ? lines : outlines).push(...ends[0], ...ends[1]);
    });
  }
  return {
    positions: Float32Array.from(found.positions), values: Float32Array.from(found.values),
    elements: Uint32Array.from(found.elements), ends: Uint32Array.from(found.ends), fractions: Float32Array.from(found.fractions),
    lines: Float32Array.from(lines), outlines: Float32Array.from(outlines),
  };
}

/** Of a quadrilateral the order of the edges makes 0, 1, 3, 2 go around. */
function addTriangles(found, points, element, values) {
  const order = points.length === 4 ? [0, 1, 3, 0, 3, 2] : points.length === 3 ? [0, 1, 2] : [];
  order.forEach((p, n) => {
    const { i, j, fraction, at } = points[p];
    found.positions.push(...at);
    found.values.push(values ? values[i] + fraction * (values[j] - values[i]) : 0);
    found.ends.push(i, j);
    found.fractions.push(fraction);
    if (n % 3 === 0) found.elements.push(element);
  });
}
