// The occupied cells, coloured by object: one box each, drawn together.

import * as THREE from "three";
import { colourOf } from "./colours.js";

const SHARE = 0.86; // of a cell's edge, so that neighbours can be told apart

export class Cells {
  constructor(stage) {
    this.stage = stage;
    this.mesh = null;
    this.visible = true;
    this.stamp = null;
    this.objects = [];
  }

  update(header, cells) {
    const grid = header.grid;
    if (!grid.shape || grid.stamp_s === this.stamp) return;
    this.stamp = grid.stamp_s;
    this.objects = header.objects;
    const size = grid.shape.map((n, i) => (grid.upper[i] - grid.lower[i]) / n);
    const count = cells.length / 3;
    this.reserve(count, size);
    const places = this.mesh.instanceMatrix.array;
    for (let i = 0; i < count; i++) {
      const at = 16 * i;
      for (let axis = 0; axis < 3; axis++) {
        places[at + 5 * axis] = 1;
        places[at + 12 + axis] = grid.lower[axis] + (cells[3 * i + axis] + 0.5) * size[axis];
      }
      places[at + 15] = 1;
    }
    this.paint(header.objects);
    this.mesh.count = count;
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.instanceColor.needsUpdate = true;
    this.mesh.boundingSphere = null;
  }

  paint(objects) {
    const robots = objects.filter((each) => each.kind === "Mobile").map((each) => each.name).sort();
    const colour = new THREE.Color();
    const colours = this.mesh.instanceColor.array;
    let i = 0;
    for (const thing of objects) {
      colour.set(colourOf(thing.name, thing.kind, robots));
      for (let n = 0; n < thing.cells; n++, i++) colour.toArray(colours, 3 * i);
    }
  }

  reserve(count, size) {
    if (this.mesh && this.mesh.instanceMatrix.count >= count) return;
    if (this.mesh) {
      this.stage.scene.remove(this.mesh);
      this.mesh.geometry.dispose();
      this.mesh.material.dispose();
      this.mesh.dispose();
    }
    const capacity = Math.max(1024, 2 * count);
    const box = new THREE.BoxGeometry(...size.map((edge) => SHARE * edge));
    const look = new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.45, depthWrite: false });
    this.mesh = new THREE.InstancedMesh(box, look, capacity);
    this.mesh.instanceColor = new THREE.InstancedBufferAttribute(new Float32Array(3 * capacity), 3);
    this.mesh.instanceMatrix.array.fill(0);
    this.mesh.visible = this.visible;
    this.stage.scene.add(this.mesh);
  }

  show(visible) {
    this.visible = visible;
    if (this.mesh) this.mesh.visible = visible;
  }

  /** Name of the object that an instance belongs to. */
  objectOf(instance) {
    let last = 0;
    for (const thing of this.objects) {
      last += thing.cells;
      if (instance < last) return thing.name;
    }
    return "";
  }
}
