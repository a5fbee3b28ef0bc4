// A view of a run in space: orbit camera, colours, cut, contact outline. It draws when something has changed.

import * as THREE from "three";
import { OrbitControls } from "../vendor/three/OrbitControls.js";
import { html } from "../dom.js";
import { BodyMesh } from "./body_mesh.js";
import { lookupTable } from "./colours.js";
import { NO_CUT, lineMaterial, sharedUniforms } from "./materials.js";

const BACKGROUND = 0xf4f6f8;

export class MeshView {
  element;
  #renderer;
  #scene = new THREE.Scene();
  #camera = new THREE.PerspectiveCamera(35, 1, 1e-3, 100);
  #controls;
  #shared = sharedUniforms();
  #bodies = new Map();
  #outline;
  #linked = [];
  #isDue = false;
  #watcher;

  constructor(label) {
    this.#renderer = new THREE.WebGLRenderer({ antialias: true });
    this.#renderer.setClearColor(BACKGROUND);
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    const canvas = this.#renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${label}. Drag to turn, pinch or scroll to zoom; arrow keys move, with Shift they turn.`);
    this.element = html("div", { class: "mesh-view" }, canvas);
    this.#camera.up.set(0, 0, 1);
    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#controls.listenToKeyEvents(canvas);
    this.#controls.addEventListener("change", () => this.#cameraMoved());
    this.#outline = new THREE.LineLoop(
      new THREE.BufferGeometry(), lineMaterial(this.#shared, [0.84, 0.1, 0.11, 1], { isCut: false }));
    this.#outline.material.depthTest = false;
    this.#outline.frustumCulled = false;
    this.#outline.renderOrder = 2;
    this.#scene.add(this.#outline);
    this.#watcher = new ResizeObserver(() => this.#resize());
    this.#watcher.observe(this.element);
  }

  /** Takes the bodies of a recording. */
  setBodies(bodies) {
    for (const mesh of this.#bodies.values()) {
      this.#scene.remove(mesh.group);
      mesh.dispose();
    }
    this.#bodies = new Map([...bodies].map(([name, body]) => [name, new BodyMesh(body, this.#shared)]));
    for (const mesh of this.#bodies.values()) this.#scene.add(mesh.group);
  }

  /** Looks at a sphere from a direction. */
  lookAt(centre, radius, direction) {
    const distance = radius / Math.sin((this.#camera.fov * Math.PI) / 360);
    this.#controls.target.fromArray(centre);
    this.#camera.position.fromArray(direction).setLength(distance).add(this.#controls.target);
    this.#camera.near = distance / 100;
    this.#camera.far = distance * 10;
    this.#camera.updateProjectionMatrix();
    this.#controls.update();
    this.draw();
  }

  /** Map and range of the colours. */
  setColours(map, range) {
    this.#shared.map.value.image.data.set(lookupTable(map));
    this.#shared.map.value.needsUpdate = true;
    this.#shared.range.value.fromArray(range);
    this.draw();
  }

  setVisible(name, isVisible) {
    const mesh = this.#bodies.get(name);
    if (mesh) mesh.group.visible = isVisible;
    this.draw();
  }

  /** Shows a frame; `valuesOf(name, state)` gives values by node or null; `outline` points in space, x y z each. */
  show(frame, valuesOf, cut, outline = []) {
    this.#shared.cut.value.copy(cut ? new THREE.Vector4(...cut.normal, cut.offset) : NO_CUT);
    for (const [name, mesh] of this.#bodies) {
      const state = frame.bodies.get(name);
      if (state) mesh.show(state, valuesOf(name, state), cut);
    }
    const points = Float32Array.from(outline.flat());
    this.#outline.geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    this.#outline.geometry.setAttribute("value", new THREE.BufferAttribute(new Float32Array(points.length / 3), 1));
    this.draw();
  }

  /** Moves the cameras of these views with this one. */
  linkTo(views) {
    this.#linked = views.filter((view) => view !== this);
  }

  #cameraMoved() {
    this.draw();
    for (const other of this.#linked) {
      other.#camera.position.copy(this.#camera.position);
      other.#camera.quaternion.copy(this.#camera.quaternion);
      other.#controls.target.copy(this.#controls.target);
      other.draw();
    }
  }

  /** Draws with the next picture of the screen. */
  draw() {
    if (this.#isDue) return;
    this.#isDue = true;
    requestAnimationFrame(() => this.#drawNow());
  }

  #drawNow() {
    this.#isDue = false;
    this.#renderer.render(this.#scene, this.#camera);
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
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
    this.#controls.dispose();
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
  }
}
