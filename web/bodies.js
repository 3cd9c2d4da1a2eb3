// Robots, arms and everything else with a drawing, and the cameras: primitives that hang on frames.

import * as THREE from "three";
import { colourOf } from "./colours.js";

const FRUSTUM_M = 0.45;
export const SHAPES = {
  box: new THREE.BoxGeometry(1, 1, 1),
  cylinder: new THREE.CylinderGeometry(0.5, 0.5, 1, 24).rotateX(Math.PI / 2),
  sphere: new THREE.SphereGeometry(0.5, 20, 14),
};
const UNDRAWN = new THREE.OctahedronGeometry(0.05);

export class Bodies {
  constructor(stage) {
    this.root = new THREE.Group();
    this.frames = [];
    this.placed = new Map(); // the frames by name, until the next scene
    this.bodies = [];
    this.cameras = [];
    this.version = -1;
    stage.scene.add(this.root);
    this.layers = { bodies: true, cameras: true, areas: true };
  }

  /** The next scene is another one's: nothing in it is where this one's was. */
  forget() {
    this.placed.clear();
  }

  /** Build everything anew from a scene message; until poses come, what was there before stays where it is. */
  build({ header, arrays }) {
    this.root.traverse((item) => {
      if (item.material) item.material.dispose();
      if (item.geometry && item.userData.own) item.geometry.dispose();
    });
    this.root.clear();
    this.version = header.version;
    this.frames = header.frames.map((name) => {
      const frame = new THREE.Group();
      const before = this.placed.get(name);
      if (before) frame.copy(before, false);
      frame.name = name;
      frame.visible = Boolean(before && before.visible);
      this.root.add(frame);
      return frame;
    });
    this.placed = new Map(this.frames.map((frame) => [frame.name, frame]));
    const robots = header.bodies.filter((body) => body.kind === "Mobile").map((body) => body.name).sort();
    this.bodies = header.bodies.map((body) => ({
      ...body, colour: colourOf(body.name, body.kind, robots), seed: this.frames[body.frame], meshes: [],
    }));
    header.solids.forEach((solid, i) => this.addSolid(solid, arrays, i));
    for (const body of this.bodies.filter((each) => each.meshes.length === 0)) this.addUndrawn(body);
    this.cameras = header.cameras.map((camera) => this.addCamera(camera));
    this.areas = header.areas.map((area) => this.addArea(area));
    this.show(this.layers);
  }

  addSolid(solid, arrays, i) {
    const body = this.bodies[solid.body];
    const mesh = new THREE.Mesh(SHAPES[solid.shape], new THREE.MeshLambertMaterial({ color: body.colour }));
    const [x, y, z] = arrays.solid_size.subarray(3 * i, 3 * i + 3);
    mesh.matrixAutoUpdate = false;
    mesh.matrix.set(...arrays.solid_pose.subarray(16 * i, 16 * i + 16)).scale(new THREE.Vector3(x, y, z));
    this.keep(body, mesh, this.frames[solid.frame]);
  }

  addUndrawn(body) {
    this.keep(body, new THREE.Mesh(UNDRAWN, new THREE.MeshLambertMaterial({ color: body.colour })), body.seed);
  }

  keep(body, mesh, frame) {
    mesh.userData.object = body.name;
    body.meshes.push(mesh);
    frame.add(mesh);
  }

  addCamera(camera) {
    const corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(
      ([a, b]) => new THREE.Vector3(a * camera.across, b * camera.down, 1).normalize().multiplyScalar(FRUSTUM_M));
    const ends = corners.flatMap((corner, i) => [new THREE.Vector3(), corner, corner, corners[(i + 1) % 4]]);
    const lines = new THREE.LineSegments(
      new THREE.BufferGeometry().setFromPoints(ends), new THREE.LineBasicMaterial({ color: "#d0e4ff" }));
    lines.userData.own = true;
    this.frames[camera.frame].add(lines);
    return { ...camera, seed: this.frames[camera.frame], lines };
  }

  addArea(area) {
    const size = area.upper.map((high, i) => high - area.lower[i]);
    const mesh = new THREE.Mesh(SHAPES.box, new THREE.MeshBasicMaterial({ color: "#ffb000", transparent: true, opacity: 0.16 }));
    mesh.position.set(...area.lower.map((low, i) => low + size[i] / 2));
    mesh.scale.set(...size);
    this.root.add(mesh);
    return mesh;
  }

  /** Move the frames; one without a pose is not shown. */
  move(poses) {
    this.frames.forEach((frame, i) => {
      const at = poses.subarray(7 * i, 7 * i + 7);
      frame.visible = Number.isFinite(at[0]);
      if (!frame.visible) return;
      frame.position.set(at[0], at[1], at[2]);
      frame.quaternion.set(at[3], at[4], at[5], at[6]);
    });
  }

  /** Mark the cameras that somebody complains about, and keep what is said of each. */
  complain(said) {
    for (const camera of this.cameras) {
      const faults = said.filter((each) => each.level !== "ok" && each.text.includes(camera.source));
      camera.sick = faults.length > 0;
      camera.faults = faults.flatMap((each) => each.text.split("; ").filter((part) => part.includes(camera.source)));
      camera.values = said.flatMap((each) => each.values.filter(([key]) => key.startsWith(`${camera.source} `)));
      camera.lines.material.color.set(camera.sick ? "#ff5a3c" : "#d0e4ff");
    }
  }

  /** Each camera as a line of health: "stale" when nobody says anything of it. */
  cameraHealth() {
    return this.cameras.map(({ name, source, sick, faults, values }) => {
      const level = sick ? "error" : values.length ? "ok" : "stale";
      const words = values.map(([key, value]) => `${key.slice(source.length + 1)}: ${value}`);
      return { name, level, text: sick ? faults.join("; ") : words[0] || "nobody says anything of it", values };
    });
  }

  show(layers) {
    this.layers = layers;
    for (const body of this.bodies) for (const mesh of body.meshes) mesh.visible = layers.bodies;
    for (const camera of this.cameras) camera.lines.visible = layers.cameras;
    for (const area of this.areas || []) area.visible = layers.areas;
  }

  get meshes() {
    return this.layers.bodies ? this.bodies.flatMap((body) => body.meshes) : [];
  }
}
