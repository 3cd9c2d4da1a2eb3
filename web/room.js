// The map of a room on the floor, and the marks on it: solids, lines, words.

import * as THREE from "three";
import { SHAPES } from "./bodies.js";

const UNSEEN = 255;
const UNDER_M = -0.005;

export class Room {
  constructor(stage) {
    this.root = new THREE.Group();
    this.map = new THREE.Group();
    this.marks = new THREE.Group();
    this.root.add(this.map, this.marks);
    this.texts = [];
    this.seen = [];
    stage.scene.add(this.root);
  }

  /** A map: free is light, occupied dark, unseen the background. */
  drawMap({ header, arrays }) {
    clear(this.map);
    const { width, height, resolution, origin } = header;
    const colours = new Uint8Array(4 * width * height);
    arrays.cells.forEach((value, i) => {
      const light = value === UNSEEN ? 0 : 225 - 2 * value;
      colours.set([light, light, light, value === UNSEEN ? 0 : 255], 4 * i);
    });
    const texture = new THREE.DataTexture(colours, width, height);
    texture.colorSpace = THREE.SRGBColorSpace;
    texture.needsUpdate = true;
    const size = [width * resolution, height * resolution];
    const look = new THREE.MeshBasicMaterial({ map: texture, transparent: true, alphaTest: 0.5 });
    const plane = new THREE.Mesh(new THREE.PlaneGeometry(...size).translate(size[0] / 2, size[1] / 2, 0), look);
    plane.position.set(origin[0], origin[1], UNDER_M);
    plane.rotation.z = origin[2];
    this.map.add(plane);
    this.seen = header.seen;
  }

  drawMarks({ header, arrays }) {
    clear(this.marks);
    header.solids.forEach(({ shape, colour }, i) => {
      const mesh = new THREE.Mesh(SHAPES[shape], new THREE.MeshLambertMaterial(lookOf(colour)));
      mesh.userData.shared = true;
      mesh.matrixAutoUpdate = false;
      mesh.matrix.set(...arrays.pose.subarray(16 * i, 16 * i + 16)).scale(new THREE.Vector3(...arrays.size.subarray(3 * i, 3 * i + 3)));
      this.marks.add(mesh);
    });
    let first = 0;
    for (const { count, colour } of header.lines) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(arrays.points.slice(3 * first, 3 * (first + count)), 3));
      this.marks.add(new THREE.Line(geometry, new THREE.LineBasicMaterial(lookOf(colour))));
      first += count;
    }
    this.texts = header.texts;
  }

  clear() {
    clear(this.map);
    clear(this.marks);
    this.texts = [];
    this.seen = [];
  }

  show(layers) {
    this.map.visible = layers.map;
    this.marks.visible = layers.marks;
  }
}

const lookOf = ([red, green, blue, opacity]) => ({
  color: new THREE.Color().setRGB(red, green, blue, THREE.SRGBColorSpace), opacity, transparent: opacity < 1,
});

function clear(group) {
  group.traverse((item) => {
    if (item.geometry && !item.userData.shared) item.geometry.dispose();
    if (item.material) {
      if (item.material.map) item.material.map.dispose();
      item.material.dispose();
    }
  });
  group.clear();
}
