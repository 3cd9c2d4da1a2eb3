// Ways ahead, ways behind, moves under way, rasters, and what a scan or a filter has for points: one set for each layer.

import * as THREE from "three";
import { colourOf, UNKNOWN } from "./colours.js";

const LOOKS = {
  path: { dashed: true },
  move: { dashed: false },
  driven: { dashed: false },
  raster: { dashed: false, colour: "#ffb000" },
  predicted: { dashed: false, colour: UNKNOWN },
  people: { dashed: true, colour: "#ffffff" },
  scan: { dots: true, colour: "#ff5a3c", size: 3 },
  particles: { dots: true, colour: "#cc79a7", size: 2 },
};

export class Lines {
  constructor(stage) {
    this.layers = {};
    for (const [layer, look] of Object.entries(LOOKS)) {
      const segments = look.dots
        ? new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ vertexColors: true, size: look.size, sizeAttenuation: false }))
        : new THREE.LineSegments(new THREE.BufferGeometry(), look.dashed
          ? new THREE.LineDashedMaterial({ vertexColors: true, dashSize: 0.08, gapSize: 0.05 })
          : new THREE.LineBasicMaterial({ vertexColors: true }));
      segments.frustumCulled = false;
      this.layers[layer] = { segments, capacity: 0, ...look };
      stage.scene.add(segments);
    }
  }

  update(header, points) {
    const robots = header.objects.filter((each) => each.kind === "Mobile").map((each) => each.name).sort();
    const found = Object.fromEntries(Object.keys(this.layers).map((layer) => [layer, []]));
    let first = 0;
    for (const line of header.lines) {
      if (found[line.layer]) found[line.layer].push({ ...line, first });
      first += line.count;
    }
    for (const [layer, own] of Object.entries(found)) this.draw(this.layers[layer], own, points, robots);
  }

  draw(layer, own, points, robots) {
    const vertices = own.reduce((sum, line) => sum + (layer.dots ? line.count : 2 * Math.max(0, line.count - 1)), 0);
    if (layer.capacity < vertices) this.reserve(layer, 2 * vertices);
    const geometry = layer.segments.geometry;
    geometry.setDrawRange(0, vertices);
    if (vertices === 0) return;
    const { position, color } = geometry.attributes;
    const colour = new THREE.Color();
    let at = 0;
    for (const line of own) {
      colour.set(layer.colour || colourOf(line.name, "Mobile", robots));
      for (let i = line.first; layer.dots && i < line.first + line.count; i++, at++) {
        position.array.set(points.subarray(3 * i, 3 * i + 3), 3 * at);
        colour.toArray(color.array, 3 * at);
      }
      for (let i = line.first; !layer.dots && i < line.first + line.count - 1; i++) {
        position.array.set(points.subarray(3 * i, 3 * i + 6), 3 * at);
        colour.toArray(color.array, 3 * at);
        colour.toArray(color.array, 3 * at + 3);
        at += 2;
      }
    }
    position.needsUpdate = color.needsUpdate = true;
    if (layer.dashed) measure(geometry, vertices);
  }

  reserve(layer, capacity) {
    layer.segments.geometry.dispose();
    layer.segments.geometry = new THREE.BufferGeometry();
    for (const [name, size] of [["position", 3], ["color", 3], ["lineDistance", 1]]) {
      layer.segments.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(size * capacity), size));
    }
    layer.capacity = capacity;
  }

  show(layers) {
    for (const [name, layer] of Object.entries(this.layers)) layer.segments.visible = layers[name];
  }
}

/** What dashes are laid by: the length so far. In place, as three's own makes another buffer for each picture. */
function measure(geometry, vertices) {
  const { position, lineDistance } = geometry.attributes;
  const at = position.array;
  for (let i = 0; i < vertices; i += 2) {
    const before = i === 0 ? 0 : lineDistance.array[i - 1];
    const length = Math.hypot(at[3 * i + 3] - at[3 * i], at[3 * i + 4] - at[3 * i + 1], at[3 * i + 5] - at[3 * i + 2]);
    lineDistance.array[i] = before;
    lineDistance.array[i + 1] = before + length;
  }
  lineDistance.needsUpdate = true;
}
