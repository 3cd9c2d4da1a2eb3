// Everything beside the 3-D view. Texts are set as texts, never as markup: names come from the outside.

import { sentences } from "./now.js";

const MARKS = { ok: "\u2713", warning: "\u26A0", error: "\u2716", stale: "\u2026", info: "\u00B7" };
const MOST_EVENTS = 200;
const $ = (id) => document.getElementById(id);

/** An element with a class, a text and children. */
function made(tag, text = "", ...children) {
  const element = document.createElement(tag);
  element.textContent = text;
  element.append(...children);
  return element;
}

const metres = (value) => (value === null ? "" : `${value.toFixed(2)} m`);

/** Fill a part of the page when what it shows has changed, so that focus and selection stay where they are. */
const shown = new Map();
function onChange(id, value, fill) {
  const key = JSON.stringify(value);
  if (shown.get(id) === key) return;
  shown.set(id, key);
  fill($(id));
}

function rows(id, list, cellsOf) {
  onChange(id, list, (table) => {
    const lines = list.map((item) => {
      const line = document.createElement("tr");
      for (const cell of cellsOf(item)) {
        line.append(cell instanceof Node ? cell : made("td", String(cell)));
      }
      return line;
    });
    if (lines.length === 0) {
      const none = made("td", "none");
      none.colSpan = table.tHead.rows[0].cells.length;
      none.className = "none";
      lines.push(made("tr", "", none));
    }
    table.tBodies[0].replaceChildren(...lines);
  });
}

export class Panel {
  /** @param actions what a press does: change(request), why(subject), seek(time_s). */
  constructor(actions) {
    this.actions = actions;
    this.lines = new Map(); // of events that are listed
    this.told = { nodes: [], said: [], cameras: [] }; // newest health
    this.servers = []; // of robots and arms: whether they answer
  }

  state(header) {
    const speed = header.real_time_factor === null ? "" : `, \u00D7${header.real_time_factor.toFixed(2)}`;
    $("clock").textContent = `${header.time_s.toFixed(1)} s${speed}`;
    if (!document.body.classList.contains("past")) this.stop(header);
    document.body.classList.toggle("roomed", Boolean(header.room));
    if (header.room) this.room(header.room);
    this.now(header);
    this.commander(header);
    this.tasks(header.tasks);
    this.robots(header);
    this.servers = header.servers || [];
    this.listHealth();
  }

  now(header) {
    const said = sentences(header);
    onChange("now", said, (list) => list.replaceChildren(...said.map((words) => made("li", words))));
  }

  room({ title, facts, verdicts }) {
    onChange("room-title", title, (element) => (element.textContent = title));
    onChange("room-facts", facts, (list) => list.replaceChildren(
      ...facts.flatMap(([name, value]) => [made("dt", name), made("dd", value)])));
    $("verdicts").hidden = verdicts.length === 0;
    rows("verdicts", verdicts, (each) => {
      const said = made("td", each.finding);
      if (each.reason) said.append(made("small", each.reason));
      return [each.box, each.tag, each.probability === null ? "" : `${(100 * each.probability).toFixed(1)} %`, said];
    });
  }

  /** Whether everything is stopped, as a state's header says; in a room the gate before the base stops it. */
  stop({ stop, room }) {
    const latched = Boolean(stop && stop.latched);
    document.body.classList.toggle("stopped", latched);
    let words = "everything may move";
    if (latched) words = `STOPPED: ${stop.reason}`;
    else if (!stop) words = `${room ? "who stops the robot" : "the safety monitor"} is not heard`;
    this.stopWords(words);
    $("release").hidden = !latched || !$("confirm").hidden;
    if (!latched) $("confirm").hidden = true;
  }

  /** What stands beside the stop. */
  stopWords(words) {
    onChange("stop-state", words, (element) => (element.textContent = words));
  }

  commander({ commander, buttons }) {
    const words = commander
      ? `${commander.state}${commander.busy ? ", busy" : ""}${commander.outcome ? `, ${commander.outcome}` : ""}` +
        (commander.reason ? `: ${commander.reason}` : "")
      : "not heard yet";
    onChange("state", words, (element) => (element.textContent = words));
    const means = (commander && commander.means) || "";
    onChange("means", means, (element) => (element.textContent = means));
    onChange("buttons", buttons, (group) => {
      const focused = document.activeElement && document.activeElement.dataset.label;
      group.replaceChildren(...buttons.map((button) => this.button(button)));
      const again = [...group.children].find((each) => each.dataset.label === focused);
      if (focused && again) again.focus();
    });
  }

  button({ label, target, does, request, refusal }) {
    const element = made("button", `${does} \u2192 ${target}`, made("small", refusal || label));
    element.type = "button";
    element.disabled = Boolean(refusal);
    element.dataset.label = label;
    element.dataset.target = target;
    element.addEventListener("click", () => this.actions.change(request));
    return element;
  }

  tasks(tasks) {
    const texts = tasks.map((task) => ({ ...task, left: metres(task.left_m) }));
    rows("tasks", texts, (task) => {
      const ask = made("button", "why");
      ask.type = "button";
      ask.title = `Why is ${task.goal} not served, or by whom?`;
      ask.addEventListener("click", () => this.actions.why(task.goal));
      const status = made("td", task.status);
      if (task.reason) status.append(made("small", task.reason));
      return [`${task.goal} (${task.kind})`, task.robot || "\u2013", status, task.left, made("td", "", ask)];
    });
  }

  robots({ robots, arms }) {
    const bases = robots.map((robot) => ({
      name: robot.name, what: robot.held ? "held" : "free", bad: robot.held,
      room: robot.clearance_m === null ? "nothing near" : `${metres(robot.clearance_m)} to ${robot.nearest}`,
    }));
    const sanders = arms.map((arm) => ({
      name: arm.name, bad: Boolean(arm.reason), room: "",
      what: `${arm.state}${arm.moving ? ", moves" : ""}, raster ${(100 * arm.progress).toFixed(0)} %` +
        (arm.reason ? `: ${arm.reason}` : ""),
    }));
    rows("robots", [...bases, ...sanders], (row) => {
      const what = made("td", row.what);
      what.classList.toggle("bad-word", row.bad);
      return [row.name, what, row.room];
    });
  }

  /** @param cameras name, level and text of each. */
  health({ nodes, said }, cameras) {
    this.told = { nodes, said, cameras };
    this.listHealth();
  }

  listHealth() {
    const { nodes } = this.told;
    const said = [...this.told.cameras, ...this.servers, ...this.told.said];
    const bad = said.filter((each) => each.level !== "ok").length + nodes.filter((node) => !node.alive).length;
    const well = nodes.length ? `: ${MARKS.ok} all well` : ""; // a film brings no word of the nodes
    const words = `Health${bad ? `: ${MARKS.warning} ${bad} to look at` : well}`;
    onChange("health-title", words, (element) => (element.textContent = words));
    rows("said", said, (each) => {
      const text = made("td", each.text);
      if (each.values && each.values.length) text.title = each.values.map(([key, value]) => `${key}: ${value}`).join("\n");
      return [each.name, `${MARKS[each.level]} ${each.level}`, text];
    });
    rows("nodes", nodes, (node) => {
      const rate = made("td", node.beat ? `${node.beat.rate_hz.toFixed(0)} Hz` : "");
      const age = made("td", node.beat && node.beat.p50_ms !== null ? `${node.beat.p50_ms.toFixed(0)} / ${node.beat.p99_ms.toFixed(0)}` : "");
      rate.title = age.title = node.beat ? `of ${node.beat.topic}, the most frequent of its topics that come here` : "";
      return [
        node.name, node.alive ? MARKS.ok : `${MARKS.error} gone`, rate, age,
        `${(100 * node.share).toFixed(0)} %`, node.memory_mb.toFixed(0),
      ];
    });
  }

  events(events) {
    const known = this.lines;
    this.lines = new Map();
    for (const event of events.slice(-MOST_EVENTS).reverse()) {
      const key = JSON.stringify(event);
      this.lines.set(key, known.get(key) || this.line(event));
    }
    $("event-list").replaceChildren(...this.lines.values());
  }

  line(event) {
    const line = document.createElement("li");
    const when = made("button", `${event.time_s.toFixed(1)} s`);
    when.type = "button";
    when.title = "show the cell at that moment";
    when.addEventListener("click", () => this.actions.seek(event.time_s));
    line.append(when, `${MARKS[event.level]} ${event.node}: ${event.text}`);
    if (event.times > 1) line.append(` (${event.times} times)`);
    line.classList.toggle("bad-word", event.level === "error");
    return line;
  }

  why(text) {
    $("why").hidden = false;
    $("why").textContent = text;
  }

  silent(list) {
    onChange("banner", list, (banner) => {
      banner.hidden = list.length === 0;
      banner.textContent = list.join("\n");
    });
  }

  answer({ success, message }) {
    const line = $("answer");
    line.hidden = false;
    line.classList.toggle("bad", !success);
    line.textContent = message;
  }
}
