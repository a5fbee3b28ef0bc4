// Geometry of cells of mixed kinds: surface, plane section, values along a line.

/** Kinds by VTK's cell type, nodes in the order of VTK: sides seen from outside, with all nodes around them, and tetrahedra that fill them. */
const KINDS = new Map([
  [10, { nodes: 4, sides: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], tetrahedra: [[0, 1, 2, 3]] }],
  [12, {
    nodes: 8,
    sides: [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    // Around the diagonal 0–6.
    tetrahedra: [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]],
  }],
  [13, {
    nodes: 6,
    sides: [[0, 1, 2], [3, 5, 4], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]],
    tetrahedra: [[0, 2, 1, 4], [0, 2, 4, 5], [0, 5, 4, 3]],
  }],
  [24, {
    nodes: 10,
    sides: [[0, 6, 2, 5, 1, 4], [0, 4, 1, 8, 3, 7], [1, 5, 2, 9, 3, 8], [0, 7, 3, 9, 2, 6]],
    tetrahedra: [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3], [4, 6, 7, 8], [5, 6, 4, 8], [6, 7, 8, 9], [8, 5, 6, 9]],
  }],
]);
const HEXAHEDRON = 12;
/** Triangles that fill a side, by the number of its nodes: of six every second one is the middle of an edge. */
const TRIANGLES = { 3: [[0, 1, 2]], 4: [[0, 1, 2], [0, 2, 3]], 6: [[0, 1, 5], [1, 2, 3], [3, 4, 5], [1, 3, 5]] };
const EDGES = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/** The elements of a body in their order. */
export class Cells {
  /** The nodes of all of them, one element after the other. */
  nodes;
  #types;
  #starts;

  /** Of `hexes`, eight nodes each; or of `nodes` with VTK's cell type of each element. */
  constructor(nodes, types = null) {
    this.nodes = nodes;
    this.#types = types;
    if (!types) return;
    this.#starts = new Uint32Array(types.length);
    let start = 0;
    types.forEach((type, e) => {
      if (!KINDS.has(type)) throw new Error(`The recording has elements of VTK's type ${type}, which are not known.`);
      this.#starts[e] = start;
      start += KINDS.get(type).nodes;
    });
  }

  get length() {
    return this.#types ? this.#types.length : this.nodes.length / 8;
  }

  /** Place in `nodes` where an element begins. */
  startOf(element) {
    return this.#types ? this.#starts[element] : 8 * element;
  }

  /** Number of nodes, sides and tetrahedra of an element. */
  kindOf(element) {
    return KINDS.get(this.#types ? this.#types[element] : HEXAHEDRON);
  }

  /** The nodes of an element. */
  nodesOf(element) {
    const start = this.startOf(element);
    return this.nodes.subarray(start, start + this.kindOf(element).nodes);
  }

  /** Whether another body has the same elements. */
  equals(other) {
    return (
      other.length === this.length &&
      other.nodes.length === this.nodes.length &&
      other.nodes.every((node, i) => node === this.nodes[i]) &&
      Array.from({ length: this.length }, (_, e) => e).every((e) => other.kindOf(e) === this.kindOf(e))
    );
  }
}

/** Corners of the box around points, x, y, z of each [m]. */
export function boxAround(points) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  points.forEach((c, i) => {
    low[i % 3] = Math.min(low[i % 3], c);
    high[i % 3] = Math.max(high[i % 3], c);
  });
  return { low, high };
}

/** Faces that belong to one element only: triangles, and the edges of the faces, as node indices. */
export function surfaceOf(cells, nodeCount) {
  const faces = new Map();
  for (let e = 0; e < cells.length; e++) {
    const start = cells.startOf(e);
    for (const side of cells.kindOf(e).sides) {
      const face = side.map((i) => cells.nodes[start + i]);
      const sorted = [...face].sort((a, b) => a - b);
      // Three nodes of a face are its name but for rare twins.
      const key = `${sorted[0] * nodeCount + sorted.at(-1)},${sorted[1]}`;
      faces.set(key, faces.has(key) ? null : face);
    }
  }
  const triangles = [];
  const edges = new Set();
  for (const face of faces.values()) {
    if (!face) continue;
    for (const triangle of TRIANGLES[face.length]) triangles.push(...triangle.map((i) => face[i]));
    face.forEach((node, i) => {
      const next = face[(i + 1) % face.length];
      edges.add(Math.min(node, next) * nodeCount + Math.max(node, next));
    });
  }
  const lines = [...edges].flatMap((key) => [Math.floor(key / nodeCount), key % nodeCount]);
  return { triangles: Uint32Array.from(triangles), lines: Uint32Array.from(lines) };
}

/** The section of the elements with the plane n·x = d: triangles with a value at each corner, and the elements' outlines. */
export function planeSection({ cells, positions, values, normal, offset }) {
  const corners = { positions: [], values: [] };
  const lines = [];
  const distance = (node) =>
    normal[0] * positions[3 * node] + normal[1] * positions[3 * node + 1] + normal[2] * positions[3 * node + 2] - offset;
  const heights = new Float64Array(10);
  for (let e = 0; e < cells.length; e++) {
    const [start, kind] = [cells.startOf(e), cells.kindOf(e)];
    let above = 0;
    for (let i = 0; i < kind.nodes; i++) above += (heights[i] = distance(cells.nodes[start + i])) > 0 ? 1 : 0;
    if (above === 0 || above === kind.nodes) continue;
    const cross = (a, b) => {
      const fraction = heights[a] / (heights[a] - heights[b]);
      const [i, j] = [cells.nodes[start + a], cells.nodes[start + b]];
      const at = [0, 1, 2].map((k) => positions[3 * i + k] + fraction * (positions[3 * j + k] - positions[3 * i + k]));
      return { at, value: values ? values[i] + fraction * (values[j] - values[i]) : 0 };
    };
    const isCut = ([a, b]) => heights[a] > 0 !== heights[b] > 0;
    for (const tetrahedron of kind.tetrahedra) {
      const points = EDGES.map(([a, b]) => [tetrahedron[a], tetrahedron[b]]).filter(isCut).map(([a, b]) => cross(a, b));
      // Of a quadrilateral the order of the edges makes 0, 1, 3, 2 go around.
      const order = points.length === 4 ? [0, 1, 3, 0, 3, 2] : points.length === 3 ? [0, 1, 2] : [];
      for (const i of order) {
        corners.positions.push(...points[i].at);
        corners.values.push(points[i].value);
      }
    }
    for (const side of kind.sides) {
      const ends = side.map((c, i) => [c, side[(i + 1) % side.length]]).filter(isCut).map(([a, b]) => cross(a, b).at);
      if (ends.length === 2) lines.push(...ends[0], ...ends[1]);
    }
  }
  return {
    positions: Float32Array.from(corners.positions),
    values: Float32Array.from(corners.values),
    lines: Float32Array.from(lines),
  };
}

/** Values {s, value, element} along the ray origin + s · direction, s in metres, in order: where it crosses the tetrahedra's faces. */
export function valuesAlong({ cells, positions, values, origin, direction }) {
  const found = [];
  const point = (node) => [positions[3 * node], positions[3 * node + 1], positions[3 * node + 2]];
  for (let element = 0; element < cells.length; element++) {
    const nodes = cells.nodesOf(element);
    const corners = Array.from(nodes, point);
    if (!isNear(corners, origin, direction)) continue;
    for (const t of cells.kindOf(element).tetrahedra) {
      for (const [a, b, c] of [[t[0], t[1], t[2]], [t[0], t[1], t[3]], [t[0], t[2], t[3]], [t[1], t[2], t[3]]]) {
        const hit = crossing(corners[a], corners[b], corners[c], origin, direction);
        if (!hit) continue;
        const [u, v] = hit.barycentric;
        const value = (1 - u - v) * values[nodes[a]] + u * values[nodes[b]] + v * values[nodes[c]];
        found.push({ s: hit.s, value, element });
      }
    }
  }
  return found.sort((a, b) => a.s - b.s);
}

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const crossProduct = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Whether a line comes near a few points: within their sphere. */
function isNear(corners, origin, direction) {
  const centre = [0, 1, 2].map((k) => corners.reduce((total, p) => total + p[k], 0) / corners.length);
  const radius = Math.max(...corners.map((p) => Math.hypot(...minus(p, centre))));
  return Math.hypot(...crossProduct(minus(centre, origin), direction)) <= radius * (1 + 1e-6);
}

/** Where a ray crosses a triangle (Möller and Trumbore 1997); edges count as inside. */
function crossing(a, b, c, origin, direction) {
  const [ab, ac] = [minus(b, a), minus(c, a)];
  const p = crossProduct(direction, ac);
  const determinant = dot(ab, p);
  if (Math.abs(determinant) < 1e-18) return null;
  const t = minus(origin, a);
  const u = dot(t, p) / determinant;
  const q = crossProduct(t, ab);
  const v = dot(direction, q) / determinant;
  const slack = 1e-6;
  if (u < -slack || v < -slack || u + v > 1 + slack) return null;
  return { s: dot(ac, q) / determinant, barycentric: [u, v] };
}
