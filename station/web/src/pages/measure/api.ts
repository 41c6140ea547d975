// Measuring by hand: the requests (docs/console_api.md §7, §8), typed.
import { get, getBinary, post } from '../../core/api';
import { language } from '../../core/words';
import { readMesh, type StationMesh } from '../../view3d/mesh_format';
import type { Ray, Vec3 } from '../../view3d/mesh_pick';

/** A place on the surface by angle and height; what requests take. */
export interface Place {
  theta_deg: number;
  z_mm: number;
}

/** A place as the server found it on the model. */
export interface SurfacePoint extends Place {
  position: Vec3;
  normal: Vec3;
  /** One sd, across the surface; null without covariance. */
  sigma_mm: number | null;
  knowledge: string;
}

export type Method = 'plane' | 'view' | 'geodesic' | 'tape';

export interface DistanceQuestion {
  from: Place;
  to: Place;
  via?: Place;
  view?: { azimuth_deg: number; elevation_deg: number };
  method: Method;
}

export interface Distance {
  length_mm: number;
  sigma_mm: number | null;
  measured_share: number;
  path: Vec3[];
}

export interface SectionQuestion {
  z_mm: number;
  tilt_deg?: number;
  lean_deg?: number;
}

export interface Section {
  z_mm: number;
  perimeter_mm: number;
  tape_mm: number;
  area_mm2: number;
  perimeter_sigma_mm: number | null;
  tape_sigma_mm: number | null;
  area_sigma_mm2: number | null;
  measured_share: number;
  loops: Vec3[][];
  tape: Vec3[];
}

export interface Slab {
  volume_mm3: number;
  area_mm2: number;
  volume_sigma_mm3: number | null;
  area_sigma_mm2: number | null;
}

export interface Region {
  area_mm2: number;
  volume_mm3: number;
  area_sigma_mm2?: number | null;
  volume_sigma_mm3?: number | null;
  outline: Vec3[] | Vec3[][];
}

export interface Landmark {
  id: string;
  name: string;
  /** "point" or "level". */
  kind: string;
  x_mm: number | null;
  y_mm: number | null;
  z_mm: number | null;
  theta_deg: number | null;
  sigma_mm: number | null;
  /** Null if it was not found. */
  source: string | null;
  found: boolean;
}

/** One line of `annulus measure --json`; value, sigma and interval carry the unit in their keys. */
export interface Measurement {
  id: string;
  term: string;
  definition: string;
  landmarks: string[];
  curve?: Vec3[] | null;
  curves?: Vec3[][];
  [key: string]: unknown;
}

export interface Visit {
  id: string;
  taken_ms: number;
  model: boolean;
}

export interface Difference {
  id: string;
  term: string;
  significant: boolean | null;
  [key: string]: unknown;
}

export interface Comparison {
  differences: Difference[];
  not_comparable: string[];
}

/** All lines of a measurement on the body. */
export function curvesOf(line: Measurement | undefined): Vec3[][] {
  return line?.curves ?? (line?.curve ? [line.curve] : []);
}

const units = ['mm', 'mm2', 'mm3', 'deg'] as const;
export type Unit = (typeof units)[number];

/** A number out of a line whose keys carry the unit: numberOf(line, 'value') reads value_mm, value_deg …; null if there is none. */
export function numberOf(line: Record<string, unknown>, name: string): { value: number; unit: Unit } | null {
  for (const unit of units) {
    const value = line[`${name}_${unit}`];
    if (typeof value === 'number') return { value, unit };
  }
  return null;
}

interface PickAnswer {
  hit: boolean;
  x_mm: number;
  y_mm: number;
  z_mm: number;
  theta_deg: number;
  nx: number;
  ny: number;
  nz: number;
  sigma_mm: number | null;
  knowledge: string;
}

export class MeasureApi {
  readonly #scan: string;

  constructor(readonly scan: string) {
    this.#scan = `/api/scans/${encodeURIComponent(scan)}`;
  }

  async mesh(): Promise<StationMesh> {
    return readMesh(await (await getBinary(`${this.#scan}/mesh`)).arrayBuffer());
  }

  /** Where a ray or a place meets the model; null if nowhere. */
  async pick(what: Ray | Place): Promise<SurfacePoint | null> {
    const answer = await post<PickAnswer>(`${this.#scan}/pick`, what);
    if (!answer.hit) return null;
    const { x_mm, y_mm, z_mm, theta_deg, nx, ny, nz, sigma_mm, knowledge } = answer;
    return { theta_deg, z_mm, position: [x_mm, y_mm, z_mm], normal: [nx, ny, nz], sigma_mm, knowledge };
  }

  distance(question: DistanceQuestion): Promise<Distance> {
    return post(`${this.#scan}/distance`, question);
  }

  section(question: SectionQuestion): Promise<Section> {
    return post(`${this.#scan}/section`, question);
  }

  slab(z_min_mm: number, z_max_mm: number): Promise<Slab> {
    return post(`${this.#scan}/slab`, { z_min_mm, z_max_mm });
  }

  region(a: Place, b: Place, c: Place, d: Place): Promise<Region> {
    return post(`${this.#scan}/region`, { a, b, c, d });
  }

  async landmarks(): Promise<Landmark[]> {
    return (await get<{ landmarks: Landmark[] }>(`${this.#scan}/landmarks`)).landmarks;
  }

  /** A level has no angle: only its height is taken. */
  async setLandmark(id: string, place: { theta_deg?: number; z_mm: number }): Promise<Landmark[]> {
    return (await post<{ landmarks: Landmark[] }>(`${this.#scan}/landmarks`, { set: [{ id, ...place }] })).landmarks;
  }

  async resetLandmarks(): Promise<Landmark[]> {
    return (await post<{ landmarks: Landmark[] }>(`${this.#scan}/landmarks/reset`)).landmarks;
  }

  async measurements(): Promise<Measurement[]> {
    return (await get<{ measurements: Measurement[] }>(`${this.#scan}/measurements?language=${language.value}`)).measurements;
  }

  /** Visits of the same customer, this one too. */
  async visits(): Promise<Visit[]> {
    const { customer_id } = await get<{ customer_id: string | null }>(this.#scan);
    if (!customer_id) return [];
    return (await get<{ visits: Visit[] }>(`/api/customers/${encodeURIComponent(customer_id)}`)).visits;
  }

  compare(other: string): Promise<Comparison> {
    return post('/api/compare', { scan_a: other, scan_b: this.scan });
  }
}
