// Which cameras have a free line of sight to a place, over the cells that are occupied.

import { Vector3 } from "three";

const STEP = 0.5; // of a cell's shortest edge
const NEAR_CELLS = 2; // what is so near to the place does not hide it: it may be the object's own surface

/** Who occupies a cell: a name, or undefined. Made once for a map. */
export function occupancy(header, cells) {
  const { shape, lower, upper } = header.grid;
  const size = shape.map((n, i) => (upper[i] - lower[i]) / n);
  const owners = new Map();
  let i = 0;
  for (const thing of header.objects) {
    for (const end = i + thing.cells; i < end; i++) {
      owners.set((cells[3 * i] * shape[1] + cells[3 * i + 1]) * shape[2] + cells[3 * i + 2], thing.name);
    }
  }
  return {
    edge: Math.min(...size),
    at: (point) => {
      const index = point.toArray().map((value, axis) => Math.floor((value - lower[axis]) / size[axis]));
      if (index.some((value, axis) => value < 0 || value >= shape[axis])) return undefined;
      return owners.get((index[0] * shape[1] + index[1]) * shape[2] + index[2]);
    },
  };
}

/** Each camera that has the place within its view, and what hides it there from it: "" for nothing. */
export function sights(cameras, place, name, owners) {
  const found = [];
  for (const camera of cameras) {
    if (!camera.seed.visible) continue;
    const own = camera.seed.worldToLocal(place.clone());
    if (own.z <= 0 || Math.abs(own.x) > own.z * camera.across || Math.abs(own.y) > own.z * camera.down) continue;
    found.push({ camera: camera.name, behind: hidden(camera.seed.getWorldPosition(new Vector3()), place, name, owners) });
  }
  return found;
}

function hidden(from, to, name, owners) {
  const length = from.distanceTo(to);
  const steps = Math.ceil((length - NEAR_CELLS * owners.edge) / (STEP * owners.edge));
  for (let i = 0; i < steps; i++) {
    const owner = owners.at(from.clone().lerp(to, (i * STEP * owners.edge) / length));
    if (owner === name) return "";
    if (owner !== undefined) return owner;
  }
  return "";
}
