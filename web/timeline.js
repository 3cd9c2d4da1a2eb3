// The bar below the view: which moment is shown, and the way to another one.

const $ = (id) => document.getElementById(id);
const SPEEDS = [0.25, 0.5, 1, 2, 5, 10];
const STEP_S = 0.1;
const MOST_MARKS = 300;

export class Timeline {
  /** @param actions what is asked for: seek(s), play(), pause(), step(way), speed(factor), live(). */
  constructor(actions) {
    this.actions = actions;
    this.marked = "";
    $("when").step = STEP_S;
    $("when").addEventListener("input", () => actions.seek(Number($("when").value)));
    $("play").addEventListener("click", () => (this.playing ? actions.pause() : actions.play()));
    $("step-back").addEventListener("click", () => actions.step(-1));
    $("step-on").addEventListener("click", () => actions.step(1));
    $("to-live").addEventListener("click", () => actions.live());
    for (const factor of SPEEDS) $("speed").append(new Option(`\u00D7${factor}`, factor, factor === 1, factor === 1));
    $("speed").addEventListener("change", () => actions.speed(Number($("speed").value)));
  }

  /**
   * @param state first_s, last_s, at_s: what there is and what is shown; live: the newest is shown; canLive: there is
   * something live; playing; events: all of them, of which warnings and errors are marked.
   */
  show({ first_s, last_s, at_s, live, canLive, playing, events }) {
    this.playing = playing;
    const range = $("when");
    range.min = first_s;
    range.max = Math.max(last_s, first_s + STEP_S);
    if (document.activeElement !== range || !live) range.value = live ? range.max : at_s;
    range.disabled = last_s <= first_s;
    const back_s = last_s - at_s;
    const words = live ? "live" : canLive ? `${at_s.toFixed(1)} s, ${back_s.toFixed(0)} s ago` : `${at_s.toFixed(1)} of ${last_s.toFixed(1)} s`;
    if ($("when-text").textContent !== words) $("when-text").textContent = words;
    range.setAttribute("aria-valuetext", words);
    const play = playing ? "\u2759\u2759" : "\u25B6";
    if ($("play").textContent !== play) $("play").textContent = play;
    $("play").setAttribute("aria-label", playing ? "pause" : "play");
    for (const id of ["play", "step-back", "step-on"]) $(id).disabled = range.disabled;
    $("to-live").hidden = !canLive || live;
    this.mark(events, first_s, Number(range.max));
  }

  mark(events, first_s, last_s) {
    const shown = events.filter((event) => event.level !== "info" && event.time_s >= first_s && event.time_s <= last_s).slice(-MOST_MARKS);
    const marks = $("marks");
    marks.style.setProperty("--first", first_s);
    marks.style.setProperty("--span", Math.max(last_s - first_s, STEP_S));
    const key = shown.map((event) => event.time_s).join(" ");
    if (key === this.marked) return; // the bar grows with each picture: what is on it moves by itself
    this.marked = key;
    marks.replaceChildren(...shown.map((event) => {
      const mark = document.createElement("i");
      mark.className = event.level;
      mark.title = `${event.time_s.toFixed(1)} s ${event.node}: ${event.text}`;
      mark.style.setProperty("--at", event.time_s);
      return mark;
    }));
  }
}
