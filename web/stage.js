// The 3-D view: drawn when something has changed, never for its own sake.

import * as THREE from "three";
import { OrbitControls } from "./vendor/three/OrbitControls.js";

const SPAN_M = 6; // of a cell
const MARGIN = 1.1;

export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color("#10151c");
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#5a6472", 2.2));
    const sun = new THREE.DirectionalLight("#ffffff", 1.6);
    sun.position.set(2, -3, 6);
    this.scene.add(sun);
    const floor = new THREE.GridHelper(6, 12, "#5b6b7e", "#2b3643").rotateX(Math.PI / 2);
    this.scene.add(floor);
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.05, 60);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.listenToKeyEvents(canvas);
    this.controls.addEventListener("change", () => this.invalidate());
    this.drawn = [];
    this.middle = new THREE.Vector3(0, 0, 0.5);
    this.scale = 1;
    this.waiting = false;
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.look("corner");
    this.resize();
  }

  /** Called after each picture. */
  onDrawn(callback) {
    this.drawn.push(callback);
  }

  invalidate() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    const begun = performance.now();
    this.renderer.render(this.scene, this.camera);
    for (const callback of this.drawn) callback(begun);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw(); // another size empties the canvas
  }

  /** What there is to look at: lower and upper corner on the floor, metres; of nothing, a cell about the origin. */
  surround(box) {
    const [x0, y0, x1, y1] = box.length ? box : [-SPAN_M / 2, -SPAN_M / 2, SPAN_M / 2, SPAN_M / 2];
    this.middle.set((x0 + x1) / 2, (y0 + y1) / 2, box.length ? 0 : 0.5);
    this.scale = box.length ? Math.max(0.4, (MARGIN * Math.max(x1 - x0, y1 - y0)) / SPAN_M) : 1;
  }

  /** Look from the corner, from above, or from a camera's frame. */
  look(from) {
    const back = this.scale * (this.camera.aspect < 1 ? 1.35 : 1);
    if (from === "corner") this.camera.position.set(3.4 * back, -4.2 * back, 3.6 * back).add(this.middle).setZ(3.6 * back);
    else if (from === "top") this.camera.position.set(0, -0.01, 7.2 * back).add(this.middle).setZ(7.2 * back);
    else this.camera.position.copy(from.position);
    this.controls.target.copy(this.middle);
    this.controls.update();
    this.invalidate();
  }

  /** What is under a point of the window: the first of these things that a ray meets; null for nothing. */
  pick(event, things) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(
      (2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    return ray.intersectObjects(things, false)[0] || null;
  }

  /** Where a point of the world is in the canvas, pixels; null behind the camera. */
  place(point) {
    const at = point.clone().project(this.camera);
    if (at.z > 1) return null;
    return [(0.5 + 0.5 * at.x) * this.canvas.clientWidth, (0.5 - 0.5 * at.y) * this.canvas.clientHeight];
  }
}
