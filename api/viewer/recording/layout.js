// A layout for Lichtblick and Foxglove that shows a recording: surfaces in space, forces and energies over time.

import { number, timeUnit } from "../format.js";
import { boxAround } from "../mesh/cells.js";

export function layoutOf(recording) {
  const topics = recording.topics ?? [];
  const series = (value, label) => ({ value, label, enabled: true, timestampMethod: "receiveTime" });
  const plot = (paths, title) => ({ foxglovePanelTitle: `${title}${clock(recording)}`, paths, showLegend: true, legendDisplay: "floating", xAxisVal: "timestamp", isSynced: true });
  const hasContact = topics.includes("/contact/forces");
  const panels = {
    "3D!mesh": {
      foxglovePanelTitle: "Surface, von Mises stress",
      followTf: "world",
      cameraState: camera(recording),
      // The axes of the one frame are a metre long otherwise: longer than a leg.
      scene: { transforms: { axisScale: 0.03, showLabel: false } },
      topics: Object.fromEntries(topics.filter((t) => /^\/(mesh|points)\//.test(t)).map((t) => [t, { visible: t.startsWith("/mesh/") }])),
    },
    "Plot!energy": plot([series("/energy.total_j", "sum"), series("/energy.absorbed_by_tissue_j", "absorbed by the tissue")], "Energy [J]"),
    ...(hasContact && { "Plot!force": plot([series("/contact/forces.pairs[0].force_norm_n", "force")], "Contact force [N]") }),
  };
  const right = hasContact ? { direction: "column", first: "Plot!force", second: "Plot!energy" } : "Plot!energy";
  return {
    configById: panels,
    globalVariables: {},
    userNodes: {},
    playbackConfig: { speed: 0.5 },
    layout: { direction: "row", first: "3D!mesh", second: right, splitPercentage: 60 },
  };
}

/** What a second of the stretched clock is, if the recording says by how much it is stretched. */
function clock({ run }) {
  const factor = Number(run.time_factor);
  if (!(factor > 0)) return "";
  const { factor: inUnit, name } = timeUnit(1 / factor);
  return `; 1 s here is ${number(inUnit / factor)} ${name}`;
}

/** A camera that sees all of the tissue. */
function camera({ tissue }) {
  const { low, high } = tissue ? boxAround(tissue.X) : { low: [-0.1, -0.1, -0.1], high: [0.1, 0.1, 0.1] };
  const target = low.map((l, k) => (l + high[k]) / 2);
  const distance = 1.8 * Math.hypot(...low.map((l, k) => high[k] - l));
  return { perspective: true, distance, phi: 60, thetaOffset: 45, target, targetOffset: [0, 0, 0], targetOrientation: [0, 0, 0, 1], fovy: 45, near: 0.001, far: 100 };
}
