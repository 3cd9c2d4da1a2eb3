// Names over the objects, as plain text on the canvas; none over another.

import { Vector3 } from "three";

const OVER_M = 0.18;
const HIGHEST = 6; // a name moves up by so many of its heights to be clear of others; then it is left out

export class Labels {
  constructor(parent, stage) {
    this.parent = parent;
    this.stage = stage;
    this.spans = new Map();
    this.visible = true;
  }

  show(visible) {
    this.visible = visible;
    this.parent.hidden = !visible;
  }

  place(bodies, newest, texts) {
    if (!this.visible) return;
    const wanted = new Map(); // the more a person needs one, the sooner it has its place
    const meant = new Set(newest ? newest.tasks.map((task) => task.goal.split("/")[0]) : []); // bins that somebody goes to
    for (const body of bodies.bodies) {
      if (body.seed.visible && (body.kind !== "Obstacle" || meant.has(body.name))) wanted.set(body.name, body.seed.position);
    }
    for (const thing of newest ? newest.objects : []) {
      if (thing.name.startsWith("unknown_") && thing.cells) wanted.set(thing.name, new Vector3(...thing.at));
    }
    for (const { text, at } of texts) wanted.set(text, new Vector3(...at));
    for (const camera of bodies.cameras) {
      if (camera.seed.visible && bodies.layers.cameras) {
        wanted.set(`${camera.name}${camera.sick ? " \u2716 sick" : ""}`, camera.seed.position);
      }
    }
    for (const [name, { span }] of this.spans) {
      if (!wanted.has(name)) {
        span.remove();
        this.spans.delete(name);
      }
    }
    const taken = [];
    for (const [name, position] of wanted) this.write(this.labelOf(name), position, taken);
  }

  labelOf(name) {
    if (!this.spans.has(name)) {
      const span = document.createElement("span");
      span.textContent = name;
      this.parent.append(span);
      this.spans.set(name, { span, width: span.offsetWidth, height: span.offsetHeight });
    }
    return this.spans.get(name);
  }

  write({ span, width, height }, position, taken) {
    const at = this.stage.place(position.clone().add(new Vector3(0, 0, OVER_M)));
    const free = at && freePlace(Math.round(at[0]), Math.round(at[1]), width, height, taken);
    span.hidden = !free;
    if (!free) return;
    taken.push(free);
    span.style.transform = `translate(${free.left}px, ${free.top}px)`;
  }
}

// The lowest place for a box of a size with the middle of its foot over x, y, clear of the boxes taken; or nothing.
function freePlace(x, y, width, height, taken) {
  const left = x - Math.round(width / 2);
  for (let up = 1; up <= HIGHEST; up++) {
    const box = { left, top: y - up * height, right: left + width, bottom: y - (up - 1) * height };
    if (!taken.some((other) => overlap(box, other))) return box;
  }
  return null;
}

function overlap(one, other) {
  return one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom;
}
