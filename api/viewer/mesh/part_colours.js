// Colours of tissues before there are values, the same in every drawing of a scene.

export const COLOURS = { skin: "#e6b8a2", fat: "#f3dd9a", muscle: "#c06a5c", bone: "#ece5d3", projectile: "#8b919c", other: "#cfd6dd" };

/** The colour of a part of a body of the scene: by its name, else by the family of its material, else by the role of the body. */
export function colourOfPart(body, name) {
  const material = body?.parts?.find(({ part }) => part === name || part === "*")?.material?.library ?? "";
  const role = body?.role === "projectile" ? COLOURS.projectile : COLOURS.other;
  return COLOURS[name] ?? COLOURS[material.split("/")[0]] ?? role;
}
