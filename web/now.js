// What goes on, in one sentence for each: for who looks for the first time.

const OVER = new Set(["reached", "unreachable"]);
const left = (task) => (task.left_m === null ? "" : `, ${task.left_m.toFixed(1)} m to go`);
const because = (reason) => (reason ? `: ${reason}` : "");
/** Goals of one robot alone are called PLACE/ROBOT. */
const placeOf = (task) => task.goal.split("/")[0];
const ownerOf = (task) => task.goal.split("/")[1];

/** Sentences about a state's header: whole system, robots, manipulators, goals that nobody is on the way to. */
export function sentences({ commander, tasks, robots, arms, stop }) {
  if (!commander) return [];
  const said = stop && stop.latched ? ["Everything is stopped until somebody releases it."] : [];
  const known = new Set([...robots.map((robot) => robot.name), ...tasks.map((task) => task.robot)].filter(Boolean));
  for (const name of [...known].sort()) {
    const held = robots.some((robot) => robot.name === name && robot.held);
    said.push(`${name} ${doing(tasks.filter((task) => task.robot === name && !OVER.has(task.status)))}` +
      (held ? "; the safety monitor holds it" : ""));
  }
  said.push(...arms.map(sanding), ...tasks.map(waiting).filter(Boolean));
  const goals = tasks.filter((task) => task.kind === "Debris" || task.kind === "Target");
  if (goals.length) said.push(`${goals.filter((task) => task.status === "reached").length} of ${goals.length} goals done.`);
  return said;
}

function doing(tasks) {
  const load = tasks.find((task) => task.status === "carrying" || task.status === "dropping");
  const way = tasks.find((task) => task !== load);
  if (load && load.status === "dropping") return `lets go of ${load.goal}`;
  if (load) return `carries ${load.goal}${way ? `${way.kind === "Clear" ? " and makes way" : ` to ${placeOf(way)}`}${left(way)}` : ""}`;
  if (!way) return "has nothing to do";
  if (way.status === "picking") return `picks up ${way.goal}`;
  if (way.status === "backing_out") return `backs out from ${way.kind === "Clear" ? "a manipulator's area" : way.goal}`;
  if (way.status === "failed") return `gave up ${way.goal}${because(way.reason)}`;
  if (way.status === "stopped") return `stopped on its way to ${placeOf(way)}${because(way.reason)}`;
  const what = { Home: "drives home", Clear: "makes way" }[way.kind] || `drives to ${placeOf(way)}`;
  return what + left(way);
}

function sanding({ name, state, sands, enabled, progress, reason }) {
  const done = `${(100 * progress).toFixed(0)} % of its raster done`;
  if (!sands) return `${name}: ${state}${because(reason)}`;
  return enabled ? `${name} sands the part, ${done}` : `${name} pauses${because(reason)}; ${done}`;
}

/** What is said of a goal that no robot is on the way to; nothing of one that is, is done, or is nobody's wish. */
function waiting(task) {
  const never = task.status === "unreachable";
  if ((task.robot && !never) || task.status === "reached") return "";
  if (task.kind === "Bin") return `${ownerOf(task)} ${never ? "cannot get" : "waits for its way"} to ${placeOf(task)}${because(task.reason)}`;
  if (task.kind !== "Debris" && task.kind !== "Target") return "";
  return `${never ? `Nobody can reach ${task.goal}` : `${task.goal} waits for a robot`}${because(task.reason)}`;
}
