// A surface made of the rings that a scan sends, one after another: its points, normals and triangles in arrays that
// are made once and filled as levels come (mm, station frame: z up, angles from +x counter-clockwise).

/** Distance of the surface from the axis at angle 2°·sensor_step·k; null where nothing was seen. */
export interface LevelRing {
  sweep: number;
  level: number;
  z_mm: number;
  sensor_step: number;
  radius_mm: readonly (number | null)[];
}

/** Degrees between neighbouring sensors of the ring. */
const kSensorPitch_deg = 2;
/** Neighbours whose radius differs by more belong to different parts (arm and trunk): no triangle between them. */
const kLargestStep_mm = 80;
/** Levels that are farther apart are not joined. */
const kLargestGap_mm = 40;

/** The point of reading k, or null. */
export function pointOf(ring: LevelRing, k: number): [x: number, y: number, z: number] | null {
  const radius = ring.radius_mm[k];
  if (radius === null || radius === undefined || !Number.isFinite(radius)) return null;
  const angle = (kSensorPitch_deg * ring.sensor_step * k * Math.PI) / 180;
  return [radius * Math.cos(angle), radius * Math.sin(angle), ring.z_mm];
}

/**
 * The ring as it is shown before the person has agreed: each radius is the mean of what was seen within ±`half_deg`, of
 * every `stride`-th direction. What is finer is not in the answer, so it cannot be shown either.
 */
export function veiled(ring: LevelRing, half_deg = 24, stride = 3): LevelRing {
  const count = ring.radius_mm.length;
  const half = Math.round(half_deg / (kSensorPitch_deg * ring.sensor_step));
  const mean = (centre: number): number | null => {
    let sum = 0;
    let seen = 0;
    for (let k = centre - half; k <= centre + half; k += 1) {
      const radius = ring.radius_mm[(k + count) % count];
      if (radius === null || radius === undefined) continue;
      sum += radius;
      seen += 1;
    }
    return seen > half / 2 ? sum / seen : null;
  };
  const radius_mm = [];
  for (let k = 0; k < count; k += stride) radius_mm.push(mean(k));
  return { ...ring, sensor_step: ring.sensor_step * stride, radius_mm };
}

/** The arrays of a growing surface; `vertices` and `indices` say how much of them is filled. */
export class RingSurface {
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  readonly triangles: Uint32Array;
  vertices = 0;
  indices = 0;
  #last: { ring: LevelRing; first: number } | null = null;

  /** @param columns readings of a ring; @param mostRings further ones are left out. */
  constructor(
    readonly columns: number,
    readonly mostRings: number,
  ) {
    this.positions = new Float32Array(3 * columns * mostRings);
    this.normals = new Float32Array(3 * columns * mostRings);
    this.triangles = new Uint32Array(6 * columns * mostRings);
  }

  /** Adds a ring and joins it to the one before of the same sweep. False if it does not fit. */
  add(ring: LevelRing): boolean {
    if (ring.radius_mm.length !== this.columns || this.vertices + this.columns > this.columns * this.mostRings) return false;
    const first = this.vertices;
    for (let k = 0; k < this.columns; k += 1) this.positions.set(pointOf(ring, k) ?? [0, 0, ring.z_mm], 3 * (first + k));
    const below = this.#joins(ring) ? this.#last : null;
    for (let k = 0; k < this.columns; k += 1) {
      this.#setNormal(first, k, below?.first ?? null);
      if (below) this.#join(below.ring, below.first, ring, first, k);
    }
    this.vertices += this.columns;
    this.#last = { ring, first };
    return true;
  }

  #joins(ring: LevelRing): boolean {
    const last = this.#last?.ring;
    return last !== undefined && last.sweep === ring.sweep && Math.abs(last.z_mm - ring.z_mm) <= kLargestGap_mm;
  }

  /** Two triangles between readings k and k + 1 of two rings, where all four were seen and lie on one part. */
  #join(a: LevelRing, firstA: number, b: LevelRing, firstB: number, k: number): void {
    const next = (k + 1) % this.columns;
    const radii = [a.radius_mm[k], a.radius_mm[next], b.radius_mm[k], b.radius_mm[next]];
    if (radii.some((radius) => radius === null || radius === undefined)) return;
    const known = radii as number[];
    if (Math.max(...known) - Math.min(...known) > kLargestStep_mm) return;
    // Counter-clockwise from outside, whether the ring goes up or down.
    const [low, high] = b.z_mm >= a.z_mm ? [firstA, firstB] : [firstB, firstA];
    this.triangles.set([low + k, low + next, high + k, low + next, high + next, high + k], this.indices);
    this.indices += 6;
  }

  /** Across the ring and up to the ring before; outwards. */
  #setNormal(first: number, k: number, before: number | null): void {
    const at = (index: number): [number, number, number] => [this.positions[3 * index] ?? 0, this.positions[3 * index + 1] ?? 0, this.positions[3 * index + 2] ?? 0];
    const here = at(first + k);
    const left = at(first + ((k + 1) % this.columns));
    const right = at(first + ((k + this.columns - 1) % this.columns));
    const along = [left[0] - right[0], left[1] - right[1]] as const;
    const old = before === null ? null : at(before + k);
    const up = old ? [here[0] - old[0], here[1] - old[1], here[2] - old[2]] as const : ([0, 0, 1] as const);
    const normal = [along[1] * up[2], -along[0] * up[2], along[0] * up[1] - along[1] * up[0]] as const;
    const outwards = normal[0] * here[0] + normal[1] * here[1] < 0 ? -1 : 1;
    const length = Math.hypot(...normal) || 1;
    this.normals.set(normal.map((part) => (outwards * part) / length), 3 * (first + k));
  }
}
