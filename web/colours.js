// Colours that differ without colour vision, too (after Okabe and Ito); names and shapes say the same in words.

const ROBOTS = ["#56b4e9", "#e69f00", "#f0e442", "#0072b2", "#cc79a7", "#8c564b"];
const KINDS = { Manipulator: "#d6def0", Debris: "#d55e00", Target: "#009e73", Obstacle: "#8a8f98" };
export const UNKNOWN = "#cc00ff";

/** Colour of an object; robots differ from each other by their order. */
export function colourOf(name, kind, robots) {
  if (kind === "Mobile") return ROBOTS[Math.max(0, robots.indexOf(name)) % ROBOTS.length];
  return name.startsWith("unknown_") ? UNKNOWN : KINDS[kind] || "#c0c4cc";
}
