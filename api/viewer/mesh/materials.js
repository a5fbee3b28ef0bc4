// How surfaces and lines are drawn: values as colours with lines at the thresholds, light from the eye, cut away beyond a plane.

import * as THREE from "three";
import { lookupTable } from "./colours.js";

/** A threshold that no value comes near, where there are fewer than four. */
const NO_LEVEL = 1e20;

const CUT = `
uniform vec4 cut;
varying vec3 place;
void clip() { if (cut.w < 1e9 && dot(cut.xyz, place) > cut.w) discard; }`;

const VERTEX = `
attribute float value;
varying float shown;
varying vec3 place;
varying vec3 toEye;
uniform float closer;
void main() {
  shown = value;
  vec4 inSpace = modelMatrix * vec4(position, 1.0);
  vec4 inView = viewMatrix * inSpace;
  place = inSpace.xyz;
  toEye = -inView.xyz;
  gl_Position = projectionMatrix * inView;
  gl_Position.z -= closer * gl_Position.w;
}`;

const SURFACE = `
${CUT}
uniform sampler2D map;
uniform vec2 range;
uniform float isLog;
uniform vec4 levels;
uniform vec3 plain;
uniform float isPlain;
#ifdef FILLED
uniform mat4 projectionMatrix;
#endif
uniform float shading;
varying float shown;
varying vec3 toEye;
void main() {
  clip();
  float even = (shown - range.x) / (range.y - range.x);
  float logarithmic = log(max(shown, 1e-30) / max(range.x, 1e-30)) / log(range.y / max(range.x, 1e-30));
  float fraction = clamp(isLog > 0.5 ? logarithmic : even, 0.0, 1.0);
  vec3 colour = texture2D(map, vec2((fraction * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  // In a program without a graphics card a loop over the thresholds is a third of the time of a picture.
  vec4 away = abs(shown - levels);
  float far = min(min(away.x, away.y), min(away.z, away.w)) / max(fwidth(shown), 1e-12);
  colour *= smoothstep(0.4, 1.2, far);
  colour = mix(colour, plain, isPlain);
  vec3 normal = normalize(cross(dFdx(toEye), dFdy(toEye)));
  // Light comes from the eye and a little from above; colours stay readable against the legend.
#ifdef FILLED
  gl_FragDepth = gl_FragCoord.z;
  if (!gl_FrontFacing && cut.w < 1e9) {
    // The inside of a rigid body that is cut looks like its section, and lies in the plane.
    vec3 axis = vec3(viewMatrix[0][2], viewMatrix[1][2], viewMatrix[2][2]);
    vec3 ray = isOrthographic ? axis : cameraPosition - place;
    vec3 hit = place + ray * (cut.w - dot(cut.xyz, place)) / dot(cut.xyz, ray);
    vec4 inPicture = projectionMatrix * viewMatrix * vec4(hit, 1.0);
    gl_FragDepth = 0.5 * inPicture.z / inPicture.w + 0.5;
    gl_FragColor = vec4(min(plain * 1.22, 1.0), 1.0);
    return;
  }
#endif
  float light = 0.55 + 0.45 * pow(abs(dot(normal, normalize(toEye + vec3(0.0, 0.35, 0.0) * length(toEye)))), 0.8);
  gl_FragColor = vec4(colour * mix(1.0, light, shading), 1.0);
}`;

const LINE = `
${CUT}
uniform vec4 colour;
void main() { clip(); gl_FragColor = colour; }`;

/** Nothing is cut beyond this. */
export const NO_CUT = new THREE.Vector4(0, 0, 0, 1e10);

/** Thresholds that are drawn as lines: the first four of `levels`. */
export function fourLevels(levels) {
  return new THREE.Vector4(...[0, 1, 2, 3].map((i) => levels[i] ?? NO_LEVEL));
}

/** The uniforms that all materials of one view share. */
export function sharedUniforms() {
  const texture = new THREE.DataTexture(lookupTable("values"), 256, 1);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return {
    map: { value: texture }, range: { value: new THREE.Vector2(0, 1) }, isLog: { value: 0 },
    levels: { value: fourLevels([]) }, cut: { value: NO_CUT.clone() },
  };
}

/** A surface coloured by `value`; `plain` is its colour when it has none. */
export function surfaceMaterial(shared, plain, { isCut = true, shading = 1, isFilled = false } = {}) {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: SURFACE,
    defines: isFilled ? { FILLED: 1 } : {},
    // What is closed by its section is seen from outside only.
    side: isFilled || !isCut ? THREE.DoubleSide : THREE.FrontSide,
    // Lines on the surface lie before it.
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
    uniforms: {
      map: shared.map,
      range: shared.range,
      isLog: shared.isLog,
      levels: shared.levels,
      cut: isCut ? shared.cut : { value: NO_CUT },
      plain: { value: new THREE.Color(...plain) },
      isPlain: { value: 0 },
      shading: { value: shading },
      closer: { value: 0 },
    },
  });
}

/** Lines of one colour [r, g, b, a]; `closer` moves them towards the eye, in fractions of the depth of the view. */
export function lineMaterial(shared, colour, { isCut = true, closer = 0 } = {}) {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: LINE,
    transparent: true,
    uniforms: { cut: isCut ? shared.cut : { value: NO_CUT }, colour: { value: new THREE.Vector4(...colour) }, closer: { value: closer } },
  });
}
