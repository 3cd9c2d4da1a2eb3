// Binary messages of the console (yarm.console.wire): a header in JSON, and typed arrays behind it.

const MAGIC = 0x314d5259; // "YRM1", little-endian
const TYPES = { f4: Float32Array, u2: Uint16Array, u1: Uint8Array };

/** Header and arrays of a message; arrays are views of its bytes. Throws when it is none. */
export function decode(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < 8 || view.getUint32(0, true) !== MAGIC) throw new Error("not a message of the console");
  const length = view.getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  const base = 8 + length + ((4 - (length % 4)) % 4);
  const arrays = {};
  for (const { name, type, shape, at } of header.arrays) {
    const count = shape.reduce((product, n) => product * n, 1);
    arrays[name] = new TYPES[type](buffer, base + at, count);
  }
  return { header, arrays };
}
