// node read_step.mjs DEFLECTION F.step…: reads STEP files with occt-import-js (Open CASCADE compiled to WebAssembly by others) and prints, as JSON,
// for each file the name, volume (mm³), triangles and open edges of each solid, meshed within DEFLECTION mm.
import { readFileSync } from "node:fs";
import loadOcct from "occt-import-js";

const params = { linearUnit: "millimeter", linearDeflectionType: "absolute_value", linearDeflection: Number(process.argv[2]), angularDeflection: 0.5 };

// The divergence theorem, about the first corner so that little cancels.
function volume(xyz, index) {
  const corner = (k) => [0, 1, 2].map((axis) => xyz[3 * index[k] + axis] - xyz[axis]);
  let sum = 0;
  for (let k = 0; k < index.length; k += 3) {
    const [a, b, c] = [corner(k), corner(k + 1), corner(k + 2)];
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}

// Directed edges without their opposite, corners joined by place.
function openEdges(xyz, index) {
  const place = (k) => [0, 1, 2].map((axis) => xyz[3 * index[k] + axis].toFixed(5)).join();
  const balance = new Map();
  for (let k = 0; k < index.length; k += 3) {
    const corners = [place(k), place(k + 1), place(k + 2)];
    corners.forEach((from, i) => {
      const to = corners[(i + 1) % 3];
      if (from === to) return;
      const key = from < to ? `${from}|${to}` : `${to}|${from}`;
      balance.set(key, (balance.get(key) ?? 0) + (from < to ? 1 : -1));
    });
  }
  return [...balance.values()].filter((n) => n !== 0).length;
}

const occt = await loadOcct();
const files = process.argv.slice(3).map((path) => {
  const read = occt.ReadStepFile(new Uint8Array(readFileSync(path)), params);
  const solids = (read.meshes ?? []).map((mesh) => {
    const [xyz, index] = [mesh.attributes.position.array, mesh.index.array];
    return { name: mesh.name, volume_mm3: volume(xyz, index), triangles: index.length / 3, open_edges: openEdges(xyz, index) };
  });
  return { success: read.success, solids };
});
console.log(JSON.stringify(files));
