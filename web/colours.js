// Colours that differ without colour vision, too (Okabe and Ito); names and shapes say the same in words.

const ROBOTS = ["#56b4e9", "#e69f00", "#cc79a7", "#f0e442", "#009e73", "#0072b2"];
const KINDS = { Manipulator: "#9fb6d8", Debris: "#d55e00", Target: "#009e73", Obstacle: "#8a8f98", Bin: "#b7a57a" };
const UNKNOWN = "#ff4fd8";

/** Colour of an object; robots differ from each other by their order. */
export function colourOf(name, kind, robots) {
  if (kind === "Mobile") return ROBOTS[Math.max(0, robots.indexOf(name)) % ROBOTS.length];
  return name.startsWith("unknown_") ? UNKNOWN : KINDS[kind] || "#c0c4cc";
}
