// A view of a run in space: cameras, colours, cut, names of layers, what is under the cursor. It draws when something has changed.

import * as THREE from "three";
import { html } from "../dom.js";
import { arrowBetween } from "./arrow.js";
import { BodyMesh } from "./body_mesh.js";
import { Cameras } from "./camera.js";
import { lookupTable } from "./colours.js";
import { NO_CUT, fourLevels, sharedUniforms } from "./materials.js";
import { Overlay } from "./overlay.js";
import { takeRenderer } from "./renderer.js";

/** Names of layers stand so far from the line of the impact, in radii of the first view [-]. */
const ASIDE = 0.55;
/** Of two places of a line the one that is less aside has its name, unless it is so many times as much deeper [-]. */
const STRAIGHT = 4;
/** Bone is looked for from so far above a line [m]. */
const ABOVE_BONE = 3e-3;

export class MeshView {
  element;
  /** Room for buttons over the picture. */
  corner;
  #renderer = takeRenderer();
  #scene = new THREE.Scene();
  #cameras;
  #shared = sharedUniforms();
  #bodies = new Map();
  #arrows = [];
  #overlay = new Overlay();
  #linked = [];
  #isDue = false;
  #hasSize = false;
  #watcher;
  #hint = html("output", { class: "probe", hidden: true });
  #line = null;
  #contours = [];
  #aside = 0.03;

  constructor(label) {
    const canvas = this.#renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${label}. Drag to turn, with two fingers on a touch screen; scroll or pinch to zoom; arrow keys move, with Shift they turn.`);
    this.corner = html("div", { class: "corner" });
    this.element = html("div", { class: "mesh-view" }, canvas, this.#overlay.element, this.corner, this.#hint);
    this.#cameras = new Cameras(canvas, () => this.#cameraMoved());
    canvas.addEventListener("pointermove", (event) => event.buttons === 0 && this.#point(event));
    canvas.addEventListener("pointerdown", (event) => this.#point(event));
    canvas.addEventListener("pointerleave", () => (this.#hint.hidden = true));
    this.#watcher = new ResizeObserver(() => this.#resize());
    this.#watcher.observe(this.element);
  }

  /** Words about a place: `probe({name, part, rest, of})`, null for nothing to say. */
  probe = () => null;

  /** Takes the bodies of a recording; what is already shown stays. */
  setBodies(bodies) {
    for (const mesh of this.#bodies.values()) {
      this.#scene.remove(mesh.group);
      mesh.dispose();
    }
    this.#bodies = new Map([...bodies].map(([name, body]) => [name, new BodyMesh(body, this.#shared)]));
    for (const mesh of this.#bodies.values()) this.#scene.add(mesh.group);
  }

  /** Arrows [from, to] in space [m]. */
  setArrows(arrows) {
    for (const arrow of this.#arrows.splice(0)) {
      this.#scene.remove(arrow);
      arrow.traverse((object) => (object.geometry?.dispose(), object.material?.dispose()));
    }
    this.#arrows = arrows.map(([from, to]) => arrowBetween(from, to));
    for (const arrow of this.#arrows) this.#scene.add(arrow);
  }

  /** How many bodies it has. */
  get bodyCount() {
    return this.#bodies.size;
  }

  /** Looks at a sphere from a direction. */
  lookAt({ centre, radius, direction }) {
    this.#aside = ASIDE * radius;
    this.#cameras.lookAt(centre, radius, direction);
    this.#cameraMoved();
  }

  /** Looks straight at the section: {centre, radius, normal, up}. */
  lookAcross({ centre, radius, normal, up }) {
    this.#aside = ASIDE * radius;
    this.#cameras.lookAcross(centre, radius, normal, up);
    this.#cameraMoved();
  }

  /** The line of the impact {centre, direction}, where names and ruler stand; `length` of the ruler [m]. */
  setLine(line, length) {
    this.#line = line;
    this.#overlay.setRuler(line && { origin: line.centre, direction: line.direction, length });
  }

  /** Map, range, thresholds with the names that their lines in the section get, and scale of the colours. */
  setColours(map, range, { isLog = false, levels = [], levelNames = [] } = {}) {
    this.#contours = levels.map((level, i) => ({ level, text: levelNames[i] })).filter(({ text }) => text);
    this.#shared.map.value.image.data.set(lookupTable(map));
    this.#shared.map.value.needsUpdate = true;
    this.#shared.range.value.fromArray(range);
    this.#shared.isLog.value = isLog ? 1 : 0;
    this.#shared.levels.value = fourLevels(levels);
    this.draw();
  }

  setVisible(name, isVisible) {
    const mesh = this.#bodies.get(name);
    if (mesh) mesh.group.visible = isVisible;
    this.draw();
  }

  /** Shows a frame; `valuesOf(name, state)` gives values by node or null. */
  show(frame, valuesOf, cut) {
    this.#shared.cut.value.copy(cut ? new THREE.Vector4(...cut.normal, cut.offset) : NO_CUT);
    for (const [name, mesh] of this.#bodies) {
      const state = frame.bodies.get(name) ?? mesh.body.rest;
      if (state) mesh.show(state, valuesOf(name, state), cut);
    }
    this.#overlay.setLabels(cut ? this.#labels(cut) : []);
    this.#overlay.setContours(cut ? this.#contourNames() : []);
    this.draw();
  }

  /** The name of each layer at a place of it on the section, to the right of the impact. */
  #labels(cut) {
    if (!this.#line) return [];
    const right = new THREE.Vector3(...cut.normal).cross(new THREE.Vector3(...this.#line.direction)).normalize();
    const goal = new THREE.Vector3(...this.#line.centre).addScaledVector(right, this.#aside);
    const best = new Map();
    for (const mesh of this.#bodies.values()) {
      const { parts, role } = mesh.body;
      if (!parts || !mesh.group.visible || role === "projectile") continue;
      for (const { part, at } of mesh.sectionMiddles()) {
        const away = Math.abs(right.dot(new THREE.Vector3(...at).sub(goal)));
        // Of a thick layer the near part: what is deep counts a little.
        const depth = Math.hypot(...at.map((c, k) => c - this.#line.centre[k]));
        const score = away + 0.35 * depth;
        if (score < (best.get(parts[part])?.score ?? Infinity)) best.set(parts[part], { text: parts[part], at, score });
      }
    }
    return [...best.values()];
  }

  /** The name of each threshold where its line in the section is straight below the impact, or nearly so. */
  #contourNames() {
    if (!this.#line) return [];
    const { centre, direction } = this.#line;
    const shown = [...this.#bodies.values()].filter(({ group, body }) => group.visible && body.role !== "projectile");
    return this.#contours.flatMap(({ level, text }) => {
      let [best, at] = [Infinity, null];
      for (const place of shown.flatMap((mesh) => [...mesh.placesAt(level)])) {
        const depth = direction.reduce((sum, d, k) => sum + d * (place[k] - centre[k]), 0);
        const aside = Math.hypot(...direction.map((d, k) => place[k] - centre[k] - depth * d));
        const score = Math.abs(depth) + STRAIGHT * aside;
        if (aside < this.#aside && score < best) [best, at] = [score, place];
      }
      return at ? [{ text, at, bone: this.#boneBelow(at) }] : [];
    });
  }

  /** Where bone begins straight below a place; null where there is none. */
  #boneBelow(at) {
    const bones = [...this.#bodies.values()].filter(({ group, body }) => group.visible && body.role === "bone");
    const direction = new THREE.Vector3(...this.#line.direction).normalize();
    // From a little above: the place may lie on the bone.
    const caster = new THREE.Raycaster(new THREE.Vector3(...at).addScaledVector(direction, -ABOVE_BONE), direction);
    const [hit] = caster.intersectObjects(bones.map(({ surfaceMesh }) => surfaceMesh), false);
    return hit?.point.toArray() ?? null;
  }

  /** Whether the reader has moved the camera. */
  get isMoved() {
    return this.#cameras.isMoved;
  }

  /** Moves the cameras of these views with this one. */
  linkTo(views) {
    this.#linked = views.filter((view) => view !== this);
  }

  #cameraMoved() {
    this.draw();
    for (const other of this.#linked) {
      other.#cameras.copy(this.#cameras);
      other.draw();
    }
  }

  /** What is under the pointer, in words beside it. */
  #point(event) {
    const { left, top, width, height } = this.element.getBoundingClientRect();
    const [x, y] = [event.clientX - left, event.clientY - top];
    const words = this.#wordsAt((2 * x) / width - 1, 1 - (2 * y) / height);
    this.#hint.hidden = !words;
    if (!words) return;
    this.#hint.textContent = words;
    const isRight = x > width / 2;
    this.#hint.classList.toggle("to-left", isRight);
    this.#hint.style.left = `${x}px`;
    this.#hint.style.top = `${y}px`;
  }

  #wordsAt(x, y) {
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(x, y), this.#cameras.current);
    const { cut } = this.#shared;
    const isAway = ({ point }) => cut.value.w < 1e9 && cut.value.x * point.x + cut.value.y * point.y + cut.value.z * point.z > cut.value.w + 1e-7;
    const hits = [...this.#bodies].filter(([, mesh]) => mesh.group.visible).flatMap(([name, mesh]) => {
      const surface = caster.intersectObject(mesh.surfaceMesh, false).find((hit) => !isAway(hit));
      const [section] = caster.intersectObject(mesh.sectionMesh, false);
      return [surface && { ...surface, name, mesh }, section && { ...section, name, mesh, isSection: true }].filter(Boolean);
    });
    const hit = hits.sort((a, b) => a.distance - b.distance)[0];
    if (!hit) return null;
    const corners = hit.object.geometry.getAttribute("position");
    const [a, b, c] = [hit.face.a, hit.face.b, hit.face.c].map((i) => new THREE.Vector3().fromBufferAttribute(corners, i).applyMatrix4(hit.object.matrixWorld));
    const weights = THREE.Triangle.getBarycoord(hit.point, a, b, c, new THREE.Vector3())?.toArray() ?? [1, 0, 0];
    const at = hit.mesh.at(Boolean(hit.isSection), hit.faceIndex, weights);
    return this.probe({ name: hit.name, ...(at ?? {}) });
  }

  /** Draws with the next picture of the screen. */
  draw() {
    if (this.#isDue) return;
    this.#isDue = true;
    requestAnimationFrame(() => this.#drawNow());
  }

  #drawNow() {
    this.#isDue = false;
    if (!this.#hasSize) return;
    const { clientWidth: width, clientHeight: height } = this.element;
    this.#renderer.render(this.#scene, this.#cameras.current);
    this.#overlay.draw(this.#cameras.current, this.#cameras.isFlat, width, height);
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    this.#hasSize = width > 0 && height > 0;
    if (!this.#hasSize) return;
    this.#renderer.setSize(width, height, false);
    this.#cameras.resize(width / height);
    this.#drawNow();
  }

  /** The picture as it is, as PNG. */
  picture() {
    this.#drawNow();
    return new Promise((resolve) => this.#renderer.domElement.toBlob(resolve, "image/png"));
  }

  dispose() {
    this.#watcher.disconnect();
    this.setBodies(new Map());
    this.setArrows([]);
    this.#cameras.dispose();
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
  }
}
