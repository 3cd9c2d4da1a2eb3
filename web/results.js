// The results of runs: which there are, and one of them with its tables and pictures. Texts are set as texts.

import { RemoteFilm, StoredFilm } from "./film.js";

const $ = (id) => document.getElementById(id);
const ORDER = ["robots", "goals", "contacts", "pauses", "steps", "nodes"];
const LEFT_OUT = new Set(["parameters", "versions", "layout"]);

function made(tag, text = "", ...children) {
  const element = document.createElement(tag);
  element.textContent = text;
  element.append(...children);
  return element;
}

const words = (value) => {
  if (value === null || value === undefined || value === "") return "\u2013";
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(4)));
  if (Array.isArray(value)) return value.map(words).join(", ");
  if (typeof value === "object") return Object.entries(value).map(([key, item]) => `${key} ${words(item)}`).join(", ");
  return String(value);
};

const success = (value) => (value === true ? "\u2713 success" : value === false ? "\u2716 failed" : "\u2026 unknown");

function table(names, rows) {
  const head = made("tr", "", ...names.map((name) => made("th", name.replaceAll("_", " "))));
  const body = rows.map((row) => made("tr", "", ...row.map((cell) => (cell instanceof Node ? made("td", "", cell) : made("td", words(cell))))));
  const whole = made("table", "", made("thead", "", head), made("tbody", "", ...body));
  return Object.assign(made("div", "", whole), { className: "wide" });
}

/** A table of what a summary has below one name: rows of a list, or named rows; null when it is no table. */
function tableOf(value) {
  const named = !Array.isArray(value);
  const rows = named ? Object.entries(value || {}) : value.map((item, i) => [String(i + 1), item]);
  if (!rows.length || !rows.every(([, item]) => item && typeof item === "object" && !Array.isArray(item))) return null;
  const columns = [...new Set(rows.flatMap(([, item]) => Object.keys(item)))];
  const names = named ? ["", ...columns] : columns;
  return table(names, rows.map(([name, item]) => [...(named ? [name] : []), ...columns.map((column) => item[column])]));
}

export class ResultsTab {
  /** @param play what shows a film: play(film, title); offline the only run, or null. */
  constructor(play, offline) {
    this.play = play;
    this.offline = offline;
  }

  async open() {
    $("run").hidden = true;
    $("runs").hidden = false;
    if (this.offline) return this.show(this.offline);
    try {
      const response = await fetch("/results");
      const { root, runs, message } = await response.json();
      if (!response.ok) throw new Error(message);
      this.list(root, runs);
    } catch (error) {
      $("runs").replaceChildren(made("p", `the results cannot be read: ${error.message}`));
    }
    return null;
  }

  list(root, runs) {
    if (!runs.length) {
      $("runs").replaceChildren(made("p", `no results below ${root} yet: rosrun yarm run_experiment --case 1m1ma`));
      return;
    }
    const rows = runs.map((run) => {
      const open = made("button", run.run);
      open.type = "button";
      open.dataset.run = run.run;
      open.addEventListener("click", () => this.fetch(run.run));
      const said = run.faults.length ? run.faults.join("; ") : run.reason || run.outcome || "";
      return [open, success(run.success), run.film ? "\u25B6" : "", new Date(1000 * run.written_s).toLocaleString(), said];
    });
    $("runs").replaceChildren(made("p", `${runs.length} runs below ${root}`), table(["run", "result", "film", "written", "what is said"], rows));
  }

  async fetch(run) {
    try {
      const response = await fetch(`/results/${run}/summary`);
      const found = await response.json();
      if (!response.ok) throw new Error(found.message);
      this.show({ ...found, source: (file) => `/results/${run}/file/${file}`, player: () => new RemoteFilm(`/results/${run}`) });
    } catch (error) {
      $("runs").prepend(made("p", `${run}: ${error.message}`));
    }
  }

  /** One run: name, summary, files, and whether it has a film. */
  show({ run, summary, files, film, source, player }) {
    const parts = [made("h2", `${run}: ${success(summary.success)}`)];
    parts.push(this.bar(run, files, film, source, player));
    for (const fault of summary.faults || []) parts.push(Object.assign(made("p", fault), { className: "bad-word" }));
    const plain = Object.entries(summary).filter(([name, value]) => name !== "faults" && (value === null || typeof value !== "object"));
    parts.push(Object.assign(made("dl", "", ...plain.flatMap(([name, value]) => [made("dt", name.replaceAll("_", " ")), made("dd", words(value))])), { className: "facts" }));
    const names = Object.keys(summary).filter((name) => summary[name] && typeof summary[name] === "object" && name !== "faults");
    const place = (name) => (ORDER.includes(name) ? ORDER.indexOf(name) : ORDER.length);
    for (const name of names.sort((a, b) => place(a) - place(b))) parts.push(...this.section(name, summary[name]));
    for (const file of files.filter((name) => name.endsWith(".png"))) parts.push(this.picture(file, source(file)));
    $("runs").hidden = true;
    $("run").hidden = false;
    $("run").replaceChildren(...parts);
    $("run").scrollIntoView();
  }

  bar(run, files, film, source, player) {
    const bar = Object.assign(made("p"), { className: "bar" });
    if (!this.offline) {
      const back = made("button", "\u2190 all runs");
      back.type = "button";
      back.addEventListener("click", () => this.open());
      bar.append(back);
    }
    if (film) {
      const play = made("button", "\u25B6 play this run");
      play.type = "button";
      play.id = "play-run";
      play.addEventListener("click", () => this.play(player(), run));
      bar.append(play);
    }
    for (const file of files.filter((name) => !name.endsWith(".png"))) {
      const link = made("a", file === "proof.html" ? "proof sheet" : file);
      link.href = source(file);
      link.target = "_blank";
      link.rel = "noopener";
      bar.append(" ", link);
    }
    return bar;
  }

  section(name, value) {
    const title = made("h3", name.replaceAll("_", " "));
    const found = tableOf(value);
    const inside = found || made("p", Array.isArray(value) && !value.length ? "none" : words(value));
    if (!LEFT_OUT.has(name)) return [title, inside];
    const folded = made("details", "", made("summary", name), inside);
    return [folded];
  }

  picture(file, source) {
    const image = document.createElement("img");
    image.src = source;
    image.alt = file;
    image.loading = "lazy";
    return made("figure", "", image, made("figcaption", file));
  }
}

/** The run that an exported page brings along. */
export function storedRun(stored) {
  return {
    ...stored.run, film: Boolean(stored.film), source: (file) => stored.files[file], player: () => new StoredFilm(stored.film),
  };
}
