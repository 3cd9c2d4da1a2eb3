// What is drawn of a moment, and what a click on it tells; where the moment comes from is somebody else's affair.

import { Vector3 } from "three";
import { Bodies } from "./bodies.js";
import { Cells } from "./cells.js";
import { Labels } from "./labels.js";
import { Lines } from "./lines.js";
import { Room } from "./room.js";
import { occupancy, sights } from "./sight.js";
import { Stage } from "./stage.js";

const LAYERS = {
  bodies: "drawings", cells: "occupied cells", path: "ways ahead", driven: "ways driven", move: "moves under way",
  predicted: "where movers will be", people: "where they may be before a robot stands", raster: "rasters", areas: "areas kept clear", cameras: "cameras", map: "map of the room", marks: "marks on it",
  scan: "scan", particles: "particles", names: "names",
};
const GROWN = 1.3; // a room that has grown so much is looked at anew
const CLICK_PX = 5;
const $ = (id) => document.getElementById(id);

/** Heading of a frame about the vertical, degrees. */
const turn = ({ x, y, z, w }) => ((180 / Math.PI) * Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))).toFixed(0);

export class View {
  constructor(canvas) {
    this.stage = new Stage(canvas);
    this.bodies = new Bodies(this.stage);
    this.cells = new Cells(this.stage);
    this.lines = new Lines(this.stage);
    this.room = new Room(this.stage);
    this.looked = 0;
    this.around = "";
    this.labels = new Labels($("labels"), this.stage);
    this.layers = Object.fromEntries(Object.keys(LAYERS).map((name) => [name, true]));
    this.picked = "";
    this.newest = null;
    this.said = [];
    this.stage.onDrawn(() => this.labels.place(this.bodies, this.newest, this.room.texts));
    this.listLayers();
    this.listenForClicks(canvas);
  }

  /** Called with the time a picture was begun, when it has been drawn. */
  onDrawn(callback) {
    this.stage.onDrawn(callback);
  }

  /** Another source: nothing of what is drawn may be taken for its own. */
  forget() {
    this.bodies.forget();
    this.cells.stamp = null;
    this.looked = 0;
    this.around = "";
    this.room.clear();
    this.stage.surround([]);
  }

  map(message) {
    this.room.drawMap(message);
    const [x0, y0, x1, y1] = this.room.seen;
    const span = this.room.seen.length ? Math.max(x1 - x0, y1 - y0) : 0;
    this.stage.surround(this.room.seen);
    if (span > GROWN * this.looked) {
      this.looked = span;
      this.stage.look("corner");
    }
    this.stage.invalidate();
  }

  marks(message) {
    this.room.drawMarks(message);
    this.show();
  }

  scene(message) {
    this.bodies.build(message);
    this.bodies.complain(this.said);
    this.presets();
    this.lookAround(message.header.around || []);
    this.show();
  }

  /** What a scene says there is to look at: when it is another than before, it is looked at. */
  lookAround(box) {
    if (box.join() === this.around) return;
    this.around = box.join();
    this.stage.surround(box);
    this.stage.look("corner");
  }

  health(header) {
    this.said = header.said;
    this.bodies.complain(this.said);
  }

  state(header, arrays) {
    this.newest = header;
    this.newestCells = arrays.cells;
    if (header.scene === this.bodies.version) this.bodies.move(arrays.poses);
    this.cells.update(header, arrays.cells);
    this.lines.update(header, arrays.points);
    this.describe();
    this.stage.invalidate();
  }

  show(name) {
    if (name !== undefined) this.layers[name] = !this.layers[name];
    this.bodies.show(this.layers);
    this.cells.show(this.layers.cells);
    this.lines.show(this.layers);
    this.room.show(this.layers);
    this.labels.show(this.layers.names);
    this.stage.invalidate();
  }

  listLayers() {
    for (const [name, words] of Object.entries(LAYERS)) {
      const box = document.createElement("input");
      box.type = "checkbox";
      box.dataset.layer = name;
      box.checked = true;
      box.addEventListener("change", () => this.show(name));
      const label = document.createElement("label");
      label.append(box, ` ${words}`);
      $("layer-list").append(label);
    }
  }

  presets() {
    const cameras = this.bodies.cameras.map((camera) => [camera.name, camera.seed]);
    $("presets").replaceChildren(...[["corner", "corner"], ["top", "top"], ...cameras].map(([name, from]) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.addEventListener("click", () => this.stage.look(from));
      return button;
    }));
  }

  listenForClicks(canvas) {
    let down = null;
    canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > CLICK_PX) return;
      const mesh = this.cells.mesh;
      const met = this.stage.pick(event, mesh && this.layers.cells ? [...this.bodies.meshes, mesh] : this.bodies.meshes);
      this.pick(!met ? "" : met.object === mesh ? this.cells.objectOf(met.instanceId) : met.object.userData.object);
    });
  }

  /** Which cameras have a free line of sight to the middle of the object that was clicked on. */
  seenBy(at) {
    if (!at || !this.newest.grid.shape || !this.bodies.cameras.length) return [];
    if (this.owners === undefined || this.owned !== this.newest.grid.stamp_s) {
      this.owners = occupancy(this.newest, this.newestCells);
      this.owned = this.newest.grid.stamp_s;
    }
    const found = sights(this.bodies.cameras, new Vector3(...at), this.picked, this.owners);
    const free = found.filter((each) => !each.behind).map((each) => each.camera);
    const hidden = found.filter((each) => each.behind).map((each) => `${each.camera} (behind ${each.behind})`);
    return [`in sight of: ${free.join(", ") || "no camera"}`, ...(hidden.length ? [`hidden from: ${hidden.join(", ")}`] : [])];
  }

  /** Tell what is known of an object, by its name; of none, nothing. */
  pick(name) {
    this.picked = name;
    this.describe();
  }

  /** Where an object is in the window, pixels; null for one that is not in sight. */
  screen(name) {
    const body = this.bodies.bodies.find((each) => each.name === name);
    const at = body && body.seed.visible && this.stage.place(body.seed.position);
    const box = this.stage.canvas.getBoundingClientRect();
    return at ? [box.left + at[0], box.top + at[1]] : null;
  }

  /** Of each layer whether what is in it is drawn. */
  drawn() {
    const lines = Object.entries(this.lines.layers).map(([name, layer]) => [name, layer.segments.visible]);
    return {
      bodies: this.bodies.meshes.length > 0, cells: this.cells.visible, areas: this.bodies.areas.every((area) => area.visible),
      cameras: this.bodies.cameras.every((camera) => camera.lines.visible), map: this.room.map.visible,
      marks: this.room.marks.visible, names: !this.labels.parent.hidden, ...Object.fromEntries(lines),
    };
  }

  describe() {
    const box = $("picked");
    box.hidden = !this.picked || !this.newest;
    if (box.hidden) return;
    const body = this.bodies.bodies.find((each) => each.name === this.picked);
    const thing = this.newest.objects.find((each) => each.name === this.picked);
    const task = this.newest.tasks.find((each) => each.goal === this.picked || each.robot === this.picked);
    const seen = body && body.seed.visible;
    const at = seen ? body.seed.position.toArray() : thing && thing.at;
    const kind = body ? `${body.kind}, ${body.motion}` : thing ? `${thing.kind}, registered by nobody` : "gone";
    const words = [this.picked, kind];
    if (at) words.push(`at ${at.map((value) => value.toFixed(2)).join(", ")} m${seen ? `, turned ${turn(body.seed.quaternion)}\u00B0` : ""}`);
    words.push(`cells: ${thing ? thing.cells : 0}`);
    if (thing && thing.seen_by && thing.seen_by.length) words.push(`seen by: ${thing.seen_by.map((n) => `camera ${n}`).join(", ")}`);
    words.push(...this.seenBy(at));
    if (task) words.push(`task: ${task.robot || "nobody"} \u2192 ${task.goal}, ${task.status}`);
    const text = words.join("\n");
    if (box.textContent !== text) box.textContent = text;
  }
}
