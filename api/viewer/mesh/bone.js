// The bone of a generated limb: the model leaves a hole with a held surface, the picture fills it with a solid.

import { Cells } from "./cells.js";

const WEDGE = 13;
const [AROUND, ALONG] = [48, 16];

/**
 * The bone of the limb segment in a scene document as a body of wedges; null where a scene has none, or where it is turned. The limb runs
 * along y.
 */
export function boneOf(scene) {
  const limb = (scene?.bodies ?? []).find((body) => body.role === "tissue" && body.mesh?.generator?.kind === "limb_segment");
  const { generator } = limb?.mesh ?? {};
  const { translation_m: moved = [0, 0, 0], ...turned } = limb?.placement ?? {};
  if (!generator?.bone_semi_axis_x_m || Object.keys(turned).length) return null;
  const { bone_semi_axis_x_m: a, bone_semi_axis_z_m: c = a, bone_offset_m: aside = [0, 0], length_m: length, center_m: middle = [0, 0, 0] } = generator;
  if (!(length > 0)) return null;
  const [x0, y0, z0] = middle.map((m, k) => m + moved[k]);
  const [X, nodes] = [[], []];
  for (let j = 0; j <= ALONG; j++) {
    const y = y0 + length * (j / ALONG - 0.5);
    X.push(x0 + aside[0], y, z0 + aside[1]);
    for (let i = 0; i < AROUND; i++) {
      const angle = (2 * Math.PI * i) / AROUND;
      X.push(x0 + aside[0] + a * Math.cos(angle), y, z0 + aside[1] + c * Math.sin(angle));
    }
  }
  const node = (j, i) => j * (AROUND + 1) + (i < 0 ? 0 : 1 + (i % AROUND));
  for (let j = 0; j < ALONG; j++) {
    for (let i = 0; i < AROUND; i++) nodes.push(node(j, -1), node(j, i), node(j, i + 1), node(j + 1, -1), node(j + 1, i), node(j + 1, i + 1));
  }
  const count = AROUND * ALONG;
  return {
    name: "bone", role: "bone", parts: ["bone"], V: [0, 0, 0], X: Float64Array.from(X),
    cells: new Cells(Uint32Array.from(nodes), new Uint8Array(count).fill(WEDGE)), partOf: new Uint32Array(count),
    rest: { positions: Float32Array.from(X), fields: {} },
  };
}
