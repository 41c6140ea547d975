// The body as it grows while it is scanned: rings joined to a neutral surface, the ring that moves, the foot marks.
import * as THREE from 'three';
import { RingSurface, veiled, type LevelRing } from './ring_surface';
import type { CameraPlace, Viewer } from './viewer';

const kMostRings = 1400;
/** Of the veiled surface, mm: closer levels are left out. */
const kVeilLevel_mm = 15;
const kNeutral = 0x98a1ac;
const kRingColour = 0x2f7fd1;

/** Of a head with its neck, and how far below the highest level its middle is, mm. */
const kHeadDistance_mm = 1000;
const kHeadMiddle_mm = 180;

/** Veiled: outlines without detail. Clear: every reading; only with the person's word. */
export type Showing = 'veiled' | 'clear';

interface Drawn {
  surface: RingSurface;
  mesh: THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>;
}

export class GrowingBody {
  readonly #viewer: Viewer;
  readonly #levels: LevelRing[] = [];
  readonly #ring: THREE.LineLoop;
  readonly #floor: THREE.Group;
  #drawn: Drawn | null = null;
  #showing: Showing = 'veiled';
  #lastVeiled: { sweep: number; z_mm: number } | null = null;
  readonly #what: 'body' | 'head';
  #top_mm = -Infinity;
  /** Where the camera was put; it is left alone once somebody has turned it. */
  #aimed: CameraPlace | null = null;

  /** @param ringRadius_mm of the ring of sensors, as it is drawn around the body; @param what is to be seen. */
  constructor(viewer: Viewer, ringRadius_mm: number, what: 'body' | 'head') {
    this.#viewer = viewer;
    this.#what = what;
    this.#ring = new THREE.LineLoop(circle(ringRadius_mm), new THREE.LineBasicMaterial({ color: kRingColour }));
    this.#ring.visible = false;
    this.#floor = floorMarks(ringRadius_mm);
    viewer.add(this.#ring);
    viewer.add(this.#floor);
    viewer.setCamera({ azimuth_deg: 62, elevation_deg: 8, distance_mm: 4700, target: [0, 0, 900] });
    this.#aimed = viewer.camera();
  }

  get levels(): number {
    return this.#levels.length;
  }

  add(level: LevelRing): void {
    this.#levels.push(level);
    this.#draw(level);
    this.#aim(level.z_mm);
    this.moveRing(level.z_mm);
  }

  moveRing(z_mm: number): void {
    this.#ring.visible = true;
    this.#ring.position.z = z_mm;
    this.#viewer.requestRender();
  }

  /** Changes how the body is shown, from what has come so far. */
  show(showing: Showing): void {
    if (showing === this.#showing) return;
    this.#showing = showing;
    this.#drop();
    for (const level of this.#levels) this.#draw(level);
  }

  /** Gives back the GPU's memory and forgets the levels. */
  dispose(): void {
    this.#levels.length = 0;
    this.#drop();
    for (const object of [this.#ring, this.#floor]) {
      this.#viewer.remove(object);
      object.traverse((part) => part instanceof THREE.Line && (part.geometry.dispose(), (part.material as THREE.Material).dispose()));
    }
  }

  /** A head would be small in a picture of the whole booth. */
  #aim(z_mm: number): void {
    if (this.#what === 'body' || z_mm <= this.#top_mm || this.#viewer.camera() !== this.#aimed) return;
    this.#top_mm = z_mm;
    this.#viewer.setCamera({ ...this.#aimed, distance_mm: kHeadDistance_mm, target: [0, 0, z_mm - kHeadMiddle_mm] });
    this.#aimed = this.#viewer.camera();
  }

  #draw(level: LevelRing): void {
    if (this.#showing === 'clear') return this.#append(level);
    const last = this.#lastVeiled;
    if (last && last.sweep === level.sweep && Math.abs(last.z_mm - level.z_mm) < kVeilLevel_mm) return;
    this.#lastVeiled = level;
    this.#append(veiled(level));
  }

  #append(ring: LevelRing): void {
    this.#drawn ??= this.#make(ring.radius_mm.length);
    const { surface, mesh } = this.#drawn;
    const firstVertex = surface.vertices;
    const firstIndex = surface.indices;
    if (!surface.add(ring)) return;
    const { position, normal } = mesh.geometry.attributes;
    for (const attribute of [position, normal]) sendPart(attribute as THREE.BufferAttribute, 3 * firstVertex, 3 * (surface.vertices - firstVertex));
    if (mesh.geometry.index) sendPart(mesh.geometry.index, firstIndex, surface.indices - firstIndex);
    mesh.geometry.setDrawRange(0, surface.indices);
    this.#viewer.requestRender();
  }

  #make(columns: number): Drawn {
    const surface = new RingSurface(columns, kMostRings);
    const geometry = new THREE.BufferGeometry();
    for (const [name, values] of [['position', surface.positions], ['normal', surface.normals]] as const) {
      geometry.setAttribute(name, new THREE.BufferAttribute(values, 3).setUsage(THREE.DynamicDrawUsage));
    }
    geometry.setIndex(new THREE.BufferAttribute(surface.triangles, 1).setUsage(THREE.DynamicDrawUsage));
    geometry.setDrawRange(0, 0);
    const material = new THREE.MeshStandardMaterial({ color: kNeutral, roughness: 0.95, metalness: 0, side: THREE.DoubleSide });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    this.#viewer.add(mesh);
    return { surface, mesh };
  }

  #drop(): void {
    this.#lastVeiled = null;
    if (!this.#drawn) return;
    this.#viewer.remove(this.#drawn.mesh);
    this.#drawn.mesh.geometry.dispose();
    this.#drawn.mesh.material.dispose();
    this.#drawn = null;
  }
}

/** Only what is new goes to the GPU: a level is 2 kB, the whole surface megabytes. */
function sendPart(attribute: THREE.BufferAttribute, start: number, count: number): void {
  if (count === 0) return;
  attribute.addUpdateRange(start, count);
  attribute.needsUpdate = true;
}

function circle(radius_mm: number, x = 0, y = 0, squeeze = 1): THREE.BufferGeometry {
  const points = Array.from({ length: 96 }, (_, k) => {
    const angle = (k * 2 * Math.PI) / 96;
    return new THREE.Vector3(x + squeeze * radius_mm * Math.cos(angle), y + radius_mm * Math.sin(angle), 0);
  });
  return new THREE.BufferGeometry().setFromPoints(points);
}

function floorMarks(ringRadius_mm: number): THREE.Group {
  const group = new THREE.Group();
  const mark = (geometry: THREE.BufferGeometry) => group.add(new THREE.LineLoop(geometry, new THREE.LineBasicMaterial({ color: 0x7c8794 })));
  mark(circle(ringRadius_mm));
  for (const x of [-150, 150]) mark(circle(130, x, 20, 0.4));
  return group;
}
