// A layout for Lichtblick and Foxglove that shows a recording: skins in space, forces and energies over time.

export function layoutOf(recording) {
  const topics = recording.topics ?? [];
  const visible = topics.filter((topic) => topic.startsWith("/mesh/"));
  const series = (value, label) => ({ value, label, enabled: true, timestampMethod: "receiveTime" });
  const plot = (paths, title) => ({ foxglovePanelTitle: title, paths, showLegend: true, legendDisplay: "floating", xAxisVal: "timestamp", isSynced: true });
  const hasContact = topics.includes("/contact/forces");
  const panels = {
    "3D!mesh": {
      foxglovePanelTitle: "Skin, von Mises stress",
      followTf: "world",
      cameraState: { perspective: true, distance: 0.4, phi: 60, thetaOffset: 45, target: [0, 0, 0], targetOffset: [0, 0, 0], targetOrientation: [0, 0, 0, 1], fovy: 45, near: 0.001, far: 100 },
      topics: Object.fromEntries(topics.filter((t) => /^\/(mesh|points)\//.test(t)).map((t) => [t, { visible: visible.includes(t) }])),
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
