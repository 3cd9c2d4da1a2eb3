// Names over the objects, as plain text on the canvas.

import { Vector3 } from "three";

const OVER_M = 0.18;

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
    const wanted = new Map();
    for (const camera of bodies.cameras) {
      if (camera.seed.visible && bodies.layers.cameras) {
        wanted.set(`${camera.name}${camera.sick ? " \u2716 sick" : ""}`, camera.seed.position);
      }
    }
    for (const body of bodies.bodies) {
      if (body.seed.visible && body.kind !== "Obstacle") wanted.set(body.name, body.seed.position);
    }
    for (const thing of newest ? newest.objects : []) {
      if (thing.name.startsWith("unknown_") && thing.cells) wanted.set(thing.name, new Vector3(...thing.at));
    }
    for (const { text, at } of texts) wanted.set(text, new Vector3(...at));
    for (const [name, span] of this.spans) {
      if (!wanted.has(name)) {
        span.remove();
        this.spans.delete(name);
      }
    }
    for (const [name, position] of wanted) this.write(name, position);
  }

  write(name, position) {
    let span = this.spans.get(name);
    if (!span) {
      span = document.createElement("span");
      span.textContent = name;
      this.parent.append(span);
      this.spans.set(name, span);
    }
    const at = this.stage.place(position.clone().add(new Vector3(0, 0, OVER_M)));
    span.hidden = !at;
    if (at) span.style.transform = `translate(${at[0].toFixed(0)}px, ${at[1].toFixed(0)}px) translate(-50%, -100%)`;
  }
}
