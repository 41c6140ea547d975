// The binary mesh of docs/console_api.md §7: little-endian, mm, station frame.

export type PartKind = 'body' | 'frame' | 'lens' | 'hair';
const kinds: readonly PartKind[] = ['body', 'frame', 'lens', 'hair'];

/** A run of triangles of one material. */
export interface MeshPart {
  /** First of its indices, and how many there are (three per triangle). */
  firstIndex: number;
  count: number;
  kind: PartKind;
  /** Linear light with sRGB primaries, and opacity, 0 … 1. */
  colour: [r: number, g: number, b: number, a: number];
}

export const measured = 0;
export const inferred = 1;
export const unknown = 2;

/** Triangles in the station frame (mm; z up, front +y). The arrays borrow the bytes they were read from. */
export interface StationMesh {
  positions: Float32Array;
  normals: Float32Array;
  /** Per vertex: measured, inferred or unknown. */
  knowledge: Uint8Array;
  indices: Uint32Array;
  parts: MeshPart[];
}

/** Bytes that are no mesh, or a damaged one. */
export class MeshDamaged extends Error {
  constructor(seen: string) {
    super(`read a mesh: ${seen}: load the page again; if it stays, call the service`);
  }
}

const magic = 0x4d534e41;
const version = 1;
const headerBytes = 16;
const partBytes = 28;
// Far above what a browser can show; below what would make the sums of sizes overflow.
const largestCount = 16_000_000;
const mostParts = 4096;
// No body and no booth reaches farther (mm).
const farthest = 1e5;

/** Reads a mesh. Throws MeshDamaged unless every size, index, number and kind holds: nothing else checks them later. */
export function readMesh(bytes: ArrayBuffer): StationMesh {
  if (bytes.byteLength < headerBytes) throw new MeshDamaged(`only ${bytes.byteLength} bytes`);
  const view = new DataView(bytes);
  if (view.getUint32(0, true) !== magic) throw new MeshDamaged('it does not begin like a mesh');
  if (view.getUint32(4, true) !== version) throw new MeshDamaged(`version ${view.getUint32(4, true)}, known is ${version}`);
  const vertices = view.getUint32(8, true);
  const triangles = view.getUint32(12, true);
  if (vertices > largestCount || triangles > largestCount) throw new MeshDamaged(`${vertices} vertices, ${triangles} triangles`);
  const normalsAt = headerBytes + 12 * vertices;
  const knowledgeAt = normalsAt + 12 * vertices;
  const indicesAt = knowledgeAt + 4 * Math.ceil(vertices / 4);
  const partsAt = indicesAt + 12 * triangles;
  if (bytes.byteLength < partsAt + 4) throw new MeshDamaged(`${bytes.byteLength} bytes, ${partsAt + 4} are needed`);
  const mesh = {
    positions: new Float32Array(bytes, headerBytes, 3 * vertices),
    normals: new Float32Array(bytes, normalsAt, 3 * vertices),
    knowledge: new Uint8Array(bytes, knowledgeAt, vertices),
    indices: new Uint32Array(bytes, indicesAt, 3 * triangles),
    parts: readParts(view, partsAt, 3 * triangles),
  };
  checkNumbers(mesh);
  return mesh;
}

function readParts(view: DataView, at: number, indices: number): MeshPart[] {
  const count = view.getUint32(at, true);
  if (count > mostParts || view.byteLength !== at + 4 + partBytes * count) {
    throw new MeshDamaged(`${count} parts in ${view.byteLength - at - 4} bytes`);
  }
  const parts: MeshPart[] = [];
  for (let i = 0; i < count; ++i) {
    const offset = at + 4 + partBytes * i;
    const firstIndex = view.getUint32(offset, true);
    const size = view.getUint32(offset + 4, true);
    const kind = kinds[view.getUint32(offset + 8, true)];
    if (kind === undefined) throw new MeshDamaged(`part ${i} is of kind ${view.getUint32(offset + 8, true)}`);
    if (firstIndex % 3 !== 0 || size % 3 !== 0 || firstIndex + size > indices) {
      throw new MeshDamaged(`part ${i} has indices ${firstIndex} … ${firstIndex + size} of ${indices}`);
    }
    const [r, g, b, a] = [0, 1, 2, 3].map((k) => view.getFloat32(offset + 12 + 4 * k, true)) as [number, number, number, number];
    if (![r, g, b, a].every((value) => value >= 0 && value <= 1)) throw new MeshDamaged(`part ${i} has no colour`);
    parts.push({ firstIndex, count: size, kind, colour: [r, g, b, a] });
  }
  return parts.length > 0 ? parts : [{ firstIndex: 0, count: indices, kind: 'body', colour: [0.6, 0.57, 0.54, 1] }];
}

function checkNumbers(mesh: StationMesh): void {
  for (const value of mesh.positions) {
    if (!(Math.abs(value) < farthest)) throw new MeshDamaged(`a vertex at ${value} mm`);
  }
  for (const value of mesh.normals) {
    if (!(Math.abs(value) <= 1.001)) throw new MeshDamaged(`a normal of length ${value}`);
  }
  for (const value of mesh.knowledge) {
    if (value > unknown) throw new MeshDamaged(`knowledge ${value}`);
  }
  const vertices = mesh.knowledge.length;
  for (const value of mesh.indices) {
    if (value >= vertices) throw new MeshDamaged(`vertex ${value} of ${vertices}`);
  }
}

/** Smallest and largest coordinates (mm); null for a mesh without vertices. */
export function boundsOf(mesh: StationMesh): { low: [number, number, number]; high: [number, number, number] } | null {
  if (mesh.positions.length === 0) return null;
  const low: [number, number, number] = [Infinity, Infinity, Infinity];
  const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
  mesh.positions.forEach((value, i) => {
    const axis = (i % 3) as 0 | 1 | 2;
    if (value < low[axis]) low[axis] = value;
    if (value > high[axis]) high[axis] = value;
  });
  return { low, high };
}
