// Ties what comes (live, from the last minutes, from a recorded run) to the view and the panel beside it.

import { ask, forgetToken, hasToken, setToken, takeToken } from "./commands.js";
import { KINDS, Player, RemoteFilm, StoredFilm } from "./film.js";
import { Panel } from "./panel.js";
import { ResultsTab, storedRun } from "./results.js";
import { Timeline } from "./timeline.js";
import { View } from "./view.js";
import { decode } from "./wire.js";

const RETRY_MS = [500, 1000, 2000, 4000];
const ESCAPES_MS = 600;
const SLOW_MS = 60; // a picture that takes longer to draw is followed by as long a pause
const UNSEEN_MS = 250; // between two live pictures that nobody looks at
const AT_END = "#end"; // of an address: a film is opened where the page that was live has seen it end
const INDEX_MS = 4000; // between two looks at what can be looked back at
const $ = (id) => document.getElementById(id);

const view = new View($("canvas"));
const panel = new Panel({ change: (request) => command("state", request), why, seek: (time_s) => look(time_s) });
const timeline = new Timeline({
  seek: (time_s) => look(time_s),
  play: () => look().then(() => player.play()),
  pause: () => player.pause(),
  step: (way) => look().then(() => player.step(way)),
  speed: (factor) => (player.speed = factor),
  live: () => backToLive(),
});
const stored = $("offline") && JSON.parse($("offline").textContent);
const results = new ResultsTab(openFilm, stored && storedRun(stored));
const live = new Map(); // the newest of each kind that came live
let canLive = false; // there is something live
let watching = "live"; // or "film"
let own = null; // the film of the last minutes
let player = null;
let pictures = 0;
let told = 0; // pictures that the console knows to be drawn
let attempts = 0;
let socket = null;

// Pictures.

/** Show one message of whatever is watched. */
function show({ header, arrays }) {
  if (header.kind === "scene") view.scene({ header, arrays });
  else if (header.kind === "map") view.map({ header, arrays });
  else if (header.kind === "marks") view.marks({ header, arrays });
  else if (header.kind === "health") {
    view.health(header);
    panel.health(header, view.bodies.cameraHealth());
  } else if (header.kind === "events") panel.events(eventsKnown());
  else {
    view.state(header, arrays);
    panel.state(header);
    panel.silent(header.silent);
  }
}

/** A live message: shown, or while something else is watched kept. */
function take(message) {
  const found = decode(message);
  live.set(found.header.kind, found);
  if (found.header.kind === "state") {
    pictures += 1;
    if (canLive) panel.stop(found.header);
  }
  if (watching === "live") show(found);
  else if (found.header.kind === "events") panel.events(eventsKnown());
  else if (found.header.kind === "state") setTimeout(() => tell(socket, pictures), UNSEEN_MS);
  bar();
}

/** Those of the run that is open, or, of a running system, those until now, whatever moment is shown. */
const eventsKnown = () => (player === own && live.has("events") ? live.get("events").header.events : player.index.events);

/** The console sends the next picture when this one is said to be drawn. */
function tell(to, number) {
  if (to && to === socket && socket.readyState === WebSocket.OPEN && number > told) socket.send(String((told = number)));
}

/** On a machine that draws slowly the next picture is asked for only after a pause, so that it can do something else, too. */
view.onDrawn((begun) => {
  const number = pictures;
  const drawnBy = socket;
  if (watching !== "live" || !socket) return;
  requestAnimationFrame(() => {
    const took = performance.now() - begun;
    setTimeout(() => tell(drawnBy, number), took > SLOW_MS ? took : 0);
  });
});

function connect() {
  socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
  socket.binaryType = "arraybuffer";
  pictures = told = 0;
  socket.onopen = () => {
    attempts = 0;
    panel.silent([]);
    own.load().catch(() => {});
  };
  socket.onmessage = ({ data }) => take(data);
  socket.onclose = ({ reason }) => {
    const wait = RETRY_MS[Math.min(attempts++, RETRY_MS.length - 1)];
    panel.silent([`no connection to the console${reason ? ` (${reason})` : ""}: what is shown is old; trying again`]);
    panel.stopWords("not connected");
    setTimeout(again, wait);
  };
}

/** Who listens there now may play a recorded run: an experiment has ended, and its page shows it as it was. */
async function again() {
  try {
    if (!(await (await fetch("/about")).json()).live) {
      location.hash = AT_END;
      return location.reload();
    }
  } catch {
    // nobody listens: connect says so, and comes back
  }
  return connect();
}

// The past.

function makePlayer(film) {
  const made = new Player(film, {
    show: (entry) => made === player && watching === "film" && show(entry),
    changed: () => made === player && bar(),
    failed: (text) => panel.answer({ success: false, message: text }),
  });
  return made;
}

/** Look at a moment of the film that is open; without one, at the one that is shown. */
async function look(time_s) {
  if (watching === "live") {
    const newest = live.get("state");
    player = own;
    await player.load();
    watch("film");
    if (time_s === undefined) time_s = newest ? newest.header.time_s : player.last_s;
  }
  if (time_s !== undefined) await player.seek(time_s);
}

function watch(what) {
  watching = what;
  tell(socket, pictures); // the last live one may not be drawn any more
  document.body.classList.toggle("past", what === "film" && canLive);
  view.forget();
}

function backToLive() {
  if (player) player.pause();
  player = own;
  watch("live");
  for (const kind of KINDS) if (live.has(kind)) show(live.get(kind));
  $("past-title").textContent = "";
  bar();
}

/** Open another film: of a run. */
async function openFilm(film, title) {
  if (player) player.pause();
  player = makePlayer(film);
  player.speed = Number($("speed").value);
  try {
    const index = await player.load();
    watch("film");
    $("past-title").textContent = title || index.title;
    $("past-notes").textContent = index.notes.join("\n");
    tab("view");
    await player.seek(location.hash === AT_END ? player.last_s : player.first_s);
    panel.events(index.events);
  } catch (error) {
    panel.answer({ success: false, message: `the film cannot be shown: ${error.message}` });
    if (canLive) backToLive();
  }
}

function bar() {
  const now = live.get("state");
  const inOwn = player === own;
  const last_s = inOwn && now ? Math.max(player.last_s, now.header.time_s) : player.last_s;
  timeline.show({
    first_s: player.first_s, last_s, at_s: watching === "live" ? last_s : player.at_s, live: watching === "live", canLive,
    playing: player.playing, events: eventsKnown(),
  });
}

// Tabs.

function tab(name) {
  for (const each of ["view", "results"]) {
    $(`tab-${each}`).setAttribute("aria-selected", String(each === name));
    $(each === "view" ? "main" : "results").hidden = each !== name;
  }
  if (name === "results") results.open();
}
for (const name of ["view", "results"]) $(`tab-${name}`).addEventListener("click", () => tab(name));

// Commands.

async function command(name, body) {
  const answer = await ask(`/command/${name}`, body);
  if (answer.status === 401) {
    forgetToken();
    token();
    $("token").focus();
  }
  panel.answer(answer);
  return answer;
}

async function why(subject) {
  panel.why(`${subject}: thinking ...`);
  const answer = await ask("/ask/why", { subject });
  panel.why(`${subject}: ${answer.message}`);
}

function token() {
  $("token-form").hidden = hasToken();
}

$("token-form").addEventListener("submit", async (event) => {
  event.preventDefault();
  setToken($("token").value);
  $("token").value = "";
  await command("check");
  token();
});

const stop = () => canLive && command("stop");
$("stop").addEventListener("click", stop);
let escaped = 0;
document.addEventListener("keydown", (event) => {
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "Escape") {
    if (event.timeStamp - escaped < ESCAPES_MS) stop();
    escaped = event.timeStamp;
  } else if (event.key.toLowerCase() === "s" && event.target.tagName !== "INPUT") {
    stop();
  }
});

let confirmation = "";
$("release").addEventListener("click", async () => {
  const answer = await command("release");
  confirmation = answer.confirm || "";
  $("confirm").hidden = !confirmation;
  $("release").hidden = Boolean(confirmation);
  if (confirmation) $("confirm").focus();
});
$("confirm").addEventListener("click", async () => {
  $("confirm").hidden = true;
  await command("release", { confirm: confirmation });
});

/** What the page's scene holds, for tests and for the curious. */
window.yarmConsole = {
  bodies: () => view.bodies.bodies.map((body) => ({
    name: body.name, kind: body.kind, at: body.seed.visible ? body.seed.getWorldPosition(body.seed.position.clone()).toArray() : null,
    meshes: body.meshes.length,
  })),
  cells: () => Object.fromEntries(view.cells.objects.map((thing) => [thing.name, thing.cells])),
  cellsDrawn: () => (view.cells.mesh ? view.cells.mesh.count : 0),
  newest: () => view.newest,
  pick: (name) => view.pick(name),
  screen: (name) => view.screen(name),
  eye: () => view.stage.camera.position.toArray(),
  drawn: () => view.drawn(),
  room: () => ({ seen: view.room.seen, marks: view.room.marks.children.length, texts: view.room.texts.length }),
  held: () => ({ ...view.stage.renderer.info.memory, labels: view.labels.spans.size }),
  pictures: () => pictures,
  watching: () => watching,
  film: () => ({
    first_s: player.first_s, last_s: player.last_s, at_s: player.at_s, playing: player.playing, settled: !player.busy,
    unpacked: player.unpacked.size,
  }),
};

async function begin() {
  takeToken();
  token();
  own = player = makePlayer(new RemoteFilm());
  const about = stored ? { live: false, title: stored.film.title } : await (await fetch("/about")).json();
  canLive = about.live;
  document.body.classList.toggle("recorded", !canLive);
  bar();
  if (!canLive) return openFilm(stored ? new StoredFilm(stored.film) : new RemoteFilm(), about.title);
  connect();
  const seen = () => player === own && socket.readyState === WebSocket.OPEN && document.visibilityState === "visible";
  setInterval(() => seen() && player.load().catch(() => {}), INDEX_MS);
  return null;
}

begin().catch((error) => panel.silent([`the page cannot begin: ${error.message}; load it again`]));
