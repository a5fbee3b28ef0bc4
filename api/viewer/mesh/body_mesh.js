// One body in space: its surface with values, its edges, its section with a plane and the outlines of its layers.

import * as THREE from "three";
import { surfaceOf } from "./cells.js";
import { lineMaterial, surfaceMaterial } from "./materials.js";
import { NO_SECTION, planeSection } from "./section.js";

/** Light lines: both maps begin dark, and most of a body is at the beginning. The finer the mesh, the fainter. */
const EDGE = [0.93, 0.96, 1];
const [EDGE_ALPHA, COARSE] = [0.16, 2500];
/** Dark lines on bodies of one colour. */
const EDGE_OF_COLOURED = [0.12, 0.14, 0.17];
/** Borders of layers at the cut: light over the dark end of the colours, and a dark one around the body. */
const OUTLINE = [1, 1, 1, 0.95];
const OUTLINE_OF_PLAIN = [0.12, 0.14, 0.17, 1];

/** The colour of what has no values, by role: a projectile is of neutral material, a bone of ivory. */
const PLAIN = { projectile: [0.42, 0.45, 0.5], bone: [0.76, 0.73, 0.64], tissue: [0.72, 0.72, 0.74] };

export class BodyMesh {
  group = new THREE.Group();
  #body;
  #surface = new THREE.BufferGeometry();
  #section = new THREE.BufferGeometry();
  #sectionLines = new THREE.BufferGeometry();
  #outlines = new THREE.BufferGeometry();
  #material;
  #sectionMaterial;
  #lines = null;
  #sides = null;
  #elements = null;
  #eroded = null;
  #shown = NO_SECTION;
  #state = null;

  constructor(body, shared) {
    this.#body = body;
    const points = body.cells ? new Float32Array(body.X) : body.surface.points;
    const plain = body.colour ? new THREE.Color(body.colour).convertLinearToSRGB().toArray() : PLAIN[body.role] ?? PLAIN.tissue;
    this.#material = surfaceMaterial(shared, plain, { isFilled: !body.cells });
    this.#surface.setAttribute("position", new THREE.BufferAttribute(points.slice(), 3));
    this.#surface.setAttribute("value", new THREE.BufferAttribute(new Float32Array(points.length / 3), 1));
    this.surfaceMesh = this.#add(new THREE.Mesh(this.#surface, this.#material));
    const alpha = EDGE_ALPHA * Math.min(1, COARSE / (body.cells?.length ?? 1));
    const edge = body.colour ? [...EDGE_OF_COLOURED, 2 * alpha] : [...EDGE, alpha];
    const isPlain = !body.colour && (body.role === "projectile" || body.role === "bone");
    if (body.cells && !isPlain) {
      this.#lines = new THREE.BufferGeometry();
      for (const name of ["position", "value"]) this.#lines.setAttribute(name, this.#surface.getAttribute(name));
      this.#add(new THREE.LineSegments(this.#lines, lineMaterial(shared, edge)));
    }
    if (body.cells) this.#showElements(null);
    else this.#surface.setIndex(new THREE.BufferAttribute(body.surface.triangles, 1));
    const lighter = body.colour ? plain : plain.map((c) => Math.min(1, c * 1.22));
    this.#sectionMaterial = surfaceMaterial(shared, lighter, { isCut: false, shading: 0 });
    this.sectionMesh = this.#add(new THREE.Mesh(this.#section, this.#sectionMaterial));
    if (!isPlain) this.#add(new THREE.LineSegments(this.#sectionLines, lineMaterial(shared, edge, { isCut: false })));
    this.#add(new THREE.LineSegments(this.#outlines, lineMaterial(shared, isPlain || body.colour ? OUTLINE_OF_PLAIN : OUTLINE, { isCut: false, closer: 2e-4 })));
  }

  get body() {
    return this.#body;
  }

  #add(object) {
    // Positions change with time: what lies in view is not worked out anew for that.
    object.frustumCulled = false;
    this.group.add(object);
    return object;
  }

  /** Shows the surface without elements that are `eroded`. */
  #showElements(eroded) {
    const { triangles, lines, sides, elements } = surfaceOf(this.#body, eroded);
    [this.#sides, this.#elements, this.#eroded] = [sides, elements, eroded];
    this.#surface.setIndex(new THREE.BufferAttribute(triangles, 1));
    this.#lines?.setIndex(new THREE.BufferAttribute(lines, 1));
  }

  /** Shows a state; `values` by node, null for a plain colour; `cut` {normal, offset} or null. */
  show(state, values, cut) {
    this.#state = state;
    if (state.pose) {
      this.group.position.fromArray(state.pose.position);
      this.group.quaternion.fromArray(state.pose.orientation);
    } else {
      this.#put("position", state.positions);
      if ((state.eroded ?? null) !== this.#eroded) this.#showElements(state.eroded ?? null);
    }
    if (values) this.#put("value", values);
    this.#material.uniforms.isPlain.value = this.#sectionMaterial.uniforms.isPlain.value = values ? 0 : 1;
    this.#showSection(state, values, cut);
  }

  #put(name, array) {
    const attribute = this.#surface.getAttribute(name);
    attribute.array.set(array);
    attribute.needsUpdate = true;
    this.#surface.boundingSphere = null;
  }

  #showSection(state, values, cut) {
    this.#shown = cut && this.#body.cells ? planeSection({ cells: this.#body.cells, sides: this.#sides, positions: state.positions, values, eroded: this.#eroded, ...cut }) : NO_SECTION;
    const { positions, values: colours, lines, outlines } = this.#shown;
    this.#section.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    this.#section.setAttribute("value", new THREE.BufferAttribute(colours, 1));
    this.#section.boundingSphere = null;
    for (const [geometry, points] of [[this.#sectionLines, lines], [this.#outlines, outlines]]) {
      geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
      geometry.setAttribute("value", new THREE.BufferAttribute(new Float32Array(points.length / 3), 1));
    }
  }

  /** The middle of the first triangle of each element in the section, by part: {part, at}. */
  *sectionMiddles() {
    const { positions, elements } = this.#shown;
    for (let t = 0; t < elements.length; t++) {
      if (elements[t] === elements[t - 1]) continue;
      const at = [0, 1, 2].map((k) => (positions[9 * t + k] + positions[9 * t + 3 + k] + positions[9 * t + 6 + k]) / 3);
      yield { part: this.#body.partOf[elements[t]], at };
    }
  }

  /** Where the value is at a level on the edges of the section [m]. */
  *placesAt(level) {
    const { positions, values } = this.#shown;
    for (let c = 0; c < values.length; c++) {
      const d = c % 3 === 2 ? c - 2 : c + 1;
      if (values[c] > level === values[d] > level) continue;
      const t = (level - values[c]) / (values[d] - values[c]);
      yield [0, 1, 2].map((k) => positions[3 * c + k] + t * (positions[3 * d + k] - positions[3 * c + k]));
    }
  }

  /** What is at a triangle of the section or of the surface: {part, at rest [m], of(values by node)}; null for a rigid body. */
  at(isSection, triangle, weights) {
    const { cells, partOf, X, parts } = this.#body;
    if (!cells) return null;
    const index = this.#surface.index.array;
    const element = isSection ? this.#shown.elements[triangle] : this.#elements[triangle];
    const corner = (i, values, stride, k) => {
      if (!isSection) return values[stride * index[3 * triangle + i] + k];
      const c = 3 * triangle + i;
      const [a, b] = [this.#shown.ends[2 * c], this.#shown.ends[2 * c + 1]];
      return values[stride * a + k] + this.#shown.fractions[c] * (values[stride * b + k] - values[stride * a + k]);
    };
    const of = (values, stride = 1, k = 0) => weights.reduce((sum, w, i) => sum + w * corner(i, values, stride, k), 0);
    return { part: parts[partOf[element]], rest: [0, 1, 2].map((k) => of(X, 3, k)), of: (name) => this.#state.fields?.[name] && of(this.#state.fields[name]) };
  }

  dispose() {
    this.group.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
  }
}
