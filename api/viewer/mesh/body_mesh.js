// One body in space: its surface with values, its edges, its section with a plane.

import * as THREE from "three";
import { lineMaterial, surfaceMaterial } from "./materials.js";
import { planeSection, surfaceOf } from "./cells.js";

/** Light lines: both maps begin dark, and most of a body is at the beginning. */
const EDGE = [0.93, 0.96, 1, 0.2];
const SECTION_EDGE = [0.93, 0.96, 1, 0.26];

export class BodyMesh {
  group = new THREE.Group();
  #body;
  #surface = new THREE.BufferGeometry();
  #section = new THREE.BufferGeometry();
  #sectionLines = new THREE.BufferGeometry();
  #material;

  constructor(body, shared) {
    this.#body = body;
    const points = body.cells ? Float32Array.from(body.X) : body.surface.points;
    const surface = body.cells ? surfaceOf(body.cells, points.length / 3) : { triangles: body.surface.triangles, lines: null };
    this.#material = surfaceMaterial(shared);
    this.#surface.setAttribute("position", new THREE.BufferAttribute(points.slice(), 3));
    this.#surface.setAttribute("value", new THREE.BufferAttribute(new Float32Array(points.length / 3), 1));
    this.#surface.setIndex(new THREE.BufferAttribute(surface.triangles, 1));
    this.#add(new THREE.Mesh(this.#surface, this.#material));
    if (surface.lines) {
      const lines = new THREE.BufferGeometry();
      for (const name of ["position", "value"]) lines.setAttribute(name, this.#surface.getAttribute(name));
      lines.setIndex(new THREE.BufferAttribute(surface.lines, 1));
      this.#add(new THREE.LineSegments(lines, lineMaterial(shared, EDGE)));
    }
    this.sectionMaterial = surfaceMaterial(shared, { isCut: false, shading: 0 });
    this.#add(new THREE.Mesh(this.#section, this.sectionMaterial));
    this.#add(new THREE.LineSegments(this.#sectionLines, lineMaterial(shared, SECTION_EDGE, { isCut: false })));
  }

  #add(object) {
    // Positions change with time: what lies in view is not worked out anew for that.
    object.frustumCulled = false;
    this.group.add(object);
  }

  /** Shows a state; `values` by node, null for a plain colour; `cut` {normal, offset} or null. */
  show(state, values, cut) {
    if (state.pose) {
      this.group.position.fromArray(state.pose.position);
      this.group.quaternion.fromArray(state.pose.orientation);
    } else {
      this.#put("position", state.positions);
    }
    if (values) this.#put("value", values);
    this.#material.uniforms.isPlain.value = this.sectionMaterial.uniforms.isPlain.value = values ? 0 : 1;
    this.#showSection(state, values, cut);
  }

  #put(name, array) {
    const attribute = this.#surface.getAttribute(name);
    attribute.array.set(array);
    attribute.needsUpdate = true;
  }

  #showSection(state, values, cut) {
    const isCut = cut && this.#body.cells;
    const section = isCut
      ? planeSection({ cells: this.#body.cells, positions: state.positions, values, ...cut })
      : { positions: new Float32Array(0), values: new Float32Array(0), lines: new Float32Array(0) };
    this.#section.setAttribute("position", new THREE.BufferAttribute(section.positions, 3));
    this.#section.setAttribute("value", new THREE.BufferAttribute(section.values, 1));
    this.#sectionLines.setAttribute("position", new THREE.BufferAttribute(section.lines, 3));
    const count = section.lines.length / 3;
    this.#sectionLines.setAttribute("value", new THREE.BufferAttribute(new Float32Array(count), 1));
  }

  dispose() {
    this.group.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
  }
}
