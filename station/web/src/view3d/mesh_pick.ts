// Where a ray first meets a mesh. The server's pick is the one that counts; this one follows the finger.
import type { StationMesh } from './mesh_format';

export type Vec3 = [x: number, y: number, z: number];

export interface Ray {
  /** Station frame, mm. */
  origin: Vec3;
  /** Of length 1. */
  direction: Vec3;
}

export interface MeshHit {
  point: Vec3;
  /** Interpolated, of length 1. */
  normal: Vec3;
  /** Of the nearest corner. */
  knowledge: number;
  /** Along the ray, mm. */
  distance: number;
}

/** The nearest intersection in front of the origin by Möller and Trumbore's test over all triangles (~1 ms for 40,000), or null. */
export function pickMesh(mesh: StationMesh, ray: Ray): MeshHit | null {
  const { positions: p, indices } = mesh;
  const [ox, oy, oz] = ray.origin;
  const [dx, dy, dz] = ray.direction;
  let best = Infinity;
  let first = -1;
  let bestU = 0;
  let bestV = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const a = 3 * indices[i]!, b = 3 * indices[i + 1]!, c = 3 * indices[i + 2]!;
    const ax = p[a]!, ay = p[a + 1]!, az = p[a + 2]!;
    const e1x = p[b]! - ax, e1y = p[b + 1]! - ay, e1z = p[b + 2]! - az;
    const e2x = p[c]! - ax, e2y = p[c + 1]! - ay, e2z = p[c + 2]! - az;
    const hx = dy * e2z - dz * e2y, hy = dz * e2x - dx * e2z, hz = dx * e2y - dy * e2x;
    const det = e1x * hx + e1y * hy + e1z * hz;
    if (det > -1e-12 && det < 1e-12) continue;
    const sx = ox - ax, sy = oy - ay, sz = oz - az;
    const u = (sx * hx + sy * hy + sz * hz) / det;
    if (u < 0 || u > 1) continue;
    const qx = sy * e1z - sz * e1y, qy = sz * e1x - sx * e1z, qz = sx * e1y - sy * e1x;
    const v = (dx * qx + dy * qy + dz * qz) / det;
    if (v < 0 || u + v > 1) continue;
    const t = (e2x * qx + e2y * qy + e2z * qz) / det;
    if (t <= 0 || t >= best) continue;
    best = t;
    first = i;
    bestU = u;
    bestV = v;
  }
  return first < 0 ? null : hitAt(mesh, ray, first, best, bestU, bestV);
}

function hitAt(mesh: StationMesh, ray: Ray, first: number, distance: number, u: number, v: number): MeshHit {
  const weights = [1 - u - v, u, v];
  const corners = [0, 1, 2].map((k) => mesh.indices[first + k]!);
  const normal = [0, 1, 2].map((axis) => corners.reduce((sum, corner, k) => sum + weights[k]! * mesh.normals[3 * corner + axis]!, 0));
  const length = Math.hypot(...normal) || 1;
  const heaviest = corners[weights.indexOf(Math.max(...weights))]!;
  return {
    point: [0, 1, 2].map((axis) => ray.origin[axis]! + distance * ray.direction[axis]!) as Vec3,
    normal: normal.map((value) => value / length) as Vec3,
    knowledge: mesh.knowledge[heaviest]!,
    distance,
  };
}
