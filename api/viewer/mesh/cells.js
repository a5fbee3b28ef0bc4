// Geometry of cells of mixed kinds: surface, values along a line.

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
    sides: [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
    tetrahedra: [[0, 1, 2, 5], [0, 1, 5, 4], [0, 4, 5, 3]],
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
      if (!KINDS.has(type)) throw new Error(`The recording has elements of VTK's type ${type}, which are not supported.`);
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

/** What a side of an element is: within a part, between two parts, or on the surface of the body. */
export const SIDE = { inside: 0, interface: 1, surface: 2 };

/**
 * The surface of the elements that are not `eroded`: `triangles` and `lines` (the edges of the faces) as node indices, `elements` of the
 * triangles, and `sides`: what each side of each element is, element after element.
 */
export function surfaceOf(cells, nodeCount, partOf = null, eroded = null) {
  const kinds = kindsOfSides(cells, nodeCount, partOf, eroded);
  const [triangles, elements] = [[], []];
  const edges = new Set();
  let side = 0;
  for (let e = 0; e < cells.length; e++) {
    const start = cells.startOf(e);
    for (const corners of cells.kindOf(e).sides) {
      if (kinds[side++] !== SIDE.surface) continue;
      const face = corners.map((i) => cells.nodes[start + i]);
      for (const triangle of TRIANGLES[face.length]) {
        triangles.push(...triangle.map((i) => face[i]));
        elements.push(e);
      }
      face.forEach((node, i) => {
        const next = face[(i + 1) % face.length];
        edges.add(Math.min(node, next) * nodeCount + Math.max(node, next));
      });
    }
  }
  const lines = [...edges].flatMap((key) => [Math.floor(key / nodeCount), key % nodeCount]);
  return { triangles: Uint32Array.from(triangles), lines: Uint32Array.from(lines), elements: Uint32Array.from(elements), sides: kinds };
}

/** What each side of each element is. Sides are chained by their lowest node; three nodes of a side are its name but for rare twins. */
function kindsOfSides(cells, nodeCount, partOf, eroded) {
  let count = 0;
  for (let e = 0; e < cells.length; e++) count += cells.kindOf(e).sides.length;
  const kinds = new Uint8Array(count);
  const [head, next] = [new Int32Array(nodeCount).fill(-1), new Int32Array(count)];
  const [middles, highs, elementOf] = [new Uint32Array(count), new Uint32Array(count), new Uint32Array(count)];
  let side = -1;
  for (let e = 0; e < cells.length; e++) {
    const start = cells.startOf(e);
    for (const corners of cells.kindOf(e).sides) {
      side++;
      if (eroded?.[e]) continue;
      let [low, middle, high] = [Infinity, Infinity, -1];
      for (const i of corners) {
        const node = cells.nodes[start + i];
        if (node < low) [low, middle] = [node, low];
        else if (node < middle) middle = node;
        if (node > high) high = node;
      }
      // The same side of a neighbour, or else one that may be on the surface.
      let other = head[low];
      while (other >= 0 && (middles[other] !== middle || highs[other] !== high)) other = next[other];
      if (other >= 0) {
        kinds[side] = kinds[other] = partOf && partOf[elementOf[other]] !== partOf[e] ? SIDE.interface : SIDE.inside;
      } else {
        [next[side], head[low], middles[side], highs[side], elementOf[side], kinds[side]] = [head[low], side, middle, high, e, SIDE.surface];
      }
    }
  }
  joinHanging(cells, kinds, partOf);
  return kinds;
}

/** Joins sides of four nodes with the four smaller ones on their other side, which have a node in its middle: hexahedra of two sizes. */
function joinHanging(cells, kinds, partOf) {
  const [open, around] = [new Map(), new Map()];
  const name = (face) => [...face].sort((a, b) => a - b).join();
  let side = -1;
  for (let element = 0; element < cells.length; element++) {
    const start = cells.startOf(element);
    for (const corners of cells.kindOf(element).sides) {
      side++;
      if (kinds[side] !== SIDE.surface || corners.length !== 4) continue;
      const face = { side, element, nodes: corners.map((i) => cells.nodes[start + i]) };
      open.set(name(face.nodes), face);
      for (const node of face.nodes) around.set(node, [...(around.get(node) ?? []), face]);
    }
  }
  for (const [middle, small] of around) {
    if (small.length !== 4) continue;
    const large = open.get(name(small.map(({ nodes }) => nodes[(nodes.indexOf(middle) + 2) % 4])));
    if (!large || large.nodes.includes(middle)) continue;
    const isWithin = ({ element }) => !partOf || partOf[element] === partOf[large.element];
    for (const face of small) kinds[face.side] = isWithin(face) ? SIDE.inside : SIDE.interface;
    kinds[large.side] = small.every(isWithin) ? SIDE.inside : SIDE.interface;
  }
}

/** Values {s, value, element} along the ray origin + s · direction, s in metres, in order: where it crosses the tetrahedra's faces. */
export function valuesAlong({ cells, positions, values, origin, direction, eroded = null }) {
  const found = [];
  const point = (node) => [positions[3 * node], positions[3 * node + 1], positions[3 * node + 2]];
  for (let element = 0; element < cells.length; element++) {
    if (eroded?.[element]) continue;
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
