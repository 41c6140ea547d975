// The camera around the body: where it stands, and what mouse, fingers and keys do to it.
import type { Vec3 } from './mesh_pick';

/** Where the camera stands: on a sphere about what it looks at. */
export interface CameraPlace {
  /** Station theta of the camera: front 90°, from the subject's left 135°, from the right 45°. */
  azimuth_deg: number;
  /** −89 … 89; positive looks down. */
  elevation_deg: number;
  distance_mm: number;
  target: Vec3;
}

/** Named views, on keys 1, 2, 3, 4. */
export const views = { front: 90, left45: 135, right45: 45, back: 270 } as const;
export type ViewName = keyof typeof views;

export const nearest_mm = 80;
export const farthest_mm = 12_000;
const steepest_deg = 89;
const degree = Math.PI / 180;

/** Unit vector from the target to the camera. */
export function towardsCamera(place: CameraPlace): Vec3 {
  const azimuth = place.azimuth_deg * degree;
  const elevation = place.elevation_deg * degree;
  return [Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)];
}

export function eyeOf(place: CameraPlace): Vec3 {
  const out = towardsCamera(place);
  return [0, 1, 2].map((axis) => place.target[axis]! + place.distance_mm * out[axis]!) as Vec3;
}

/** Turned to the viewer's right and up, within what a camera can do. */
export function turned(place: CameraPlace, right_deg: number, up_deg: number): CameraPlace {
  const elevation = Math.max(-steepest_deg, Math.min(steepest_deg, place.elevation_deg + up_deg));
  return { ...place, azimuth_deg: (((place.azimuth_deg + right_deg) % 360) + 360) % 360, elevation_deg: elevation };
}

/** Nearer for a factor below 1. */
export function zoomed(place: CameraPlace, factor: number): CameraPlace {
  return { ...place, distance_mm: Math.max(nearest_mm, Math.min(farthest_mm, place.distance_mm * factor)) };
}

/** Moved by mm across the picture: what is looked at goes to the right and up of where it was. */
export function shifted(place: CameraPlace, right_mm: number, up_mm: number): CameraPlace {
  const azimuth = place.azimuth_deg * degree;
  const elevation = place.elevation_deg * degree;
  const right: Vec3 = [-Math.sin(azimuth), Math.cos(azimuth), 0];
  const up: Vec3 = [-Math.sin(elevation) * Math.cos(azimuth), -Math.sin(elevation) * Math.sin(azimuth), Math.cos(elevation)];
  const target = place.target.map((value, axis) => value + right_mm * right[axis]! + up_mm * up[axis]!) as Vec3;
  return { ...place, target };
}

/** Part of the way from one place to another, azimuth the short way round. */
export function between(from: CameraPlace, to: CameraPlace, share: number): CameraPlace {
  const mix = (a: number, b: number): number => a + share * (b - a);
  const turn = ((to.azimuth_deg - from.azimuth_deg + 540) % 360) - 180;
  return {
    azimuth_deg: (((from.azimuth_deg + share * turn) % 360) + 360) % 360,
    elevation_deg: mix(from.elevation_deg, to.elevation_deg),
    distance_mm: mix(from.distance_mm, to.distance_mm),
    target: from.target.map((value, axis) => mix(value, to.target[axis]!)) as Vec3,
  };
}

/** What a key does; null if nothing. */
export function keyed(place: CameraPlace, key: string): CameraPlace | null {
  switch (key) {
    case 'ArrowLeft': return turned(place, -10, 0);
    case 'ArrowRight': return turned(place, 10, 0);
    case 'ArrowUp': return turned(place, 0, 10);
    case 'ArrowDown': return turned(place, 0, -10);
    case '+': case '=': return zoomed(place, 1 / 1.15);
    case '-': case '_': return zoomed(place, 1.15);
    case '1': return { ...place, azimuth_deg: views.front, elevation_deg: 0 };
    case '2': return { ...place, azimuth_deg: views.left45, elevation_deg: 0 };
    case '3': return { ...place, azimuth_deg: views.right45, elevation_deg: 0 };
    case '4': return { ...place, azimuth_deg: views.back, elevation_deg: 0 };
    default: return null;
  }
}

/** What the orbit moves: the viewer. */
export interface OrbitHost {
  readonly element: HTMLElement;
  place(): CameraPlace;
  setPlace(place: CameraPlace): void;
  /** mm across the picture per pixel at the target. */
  mmPerPixel(): number;
  /** A press that belongs to something in the picture (a mark that is dragged): true, and the camera stays. */
  claims(event: PointerEvent): boolean;
  moving(now: boolean): void;
}

/**
 * Mouse (left turns, right or Shift shifts, wheel zooms), touch (one finger turns, two pinch and shift) and keys.
 * What is returned ends it.
 */
export function attachOrbit(host: OrbitHost): () => void {
  const pointers = new Map<number, { x: number; y: number }>();
  const { element } = host;
  const ends = new AbortController();
  const { signal } = ends;
  let wheelEnd = 0;

  const down = (event: PointerEvent): void => {
    if (pointers.size === 0 && host.claims(event)) return;
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    host.moving(true);
  };
  const move = (event: PointerEvent): void => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const now = { x: event.clientX, y: event.clientY };
    const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    pointers.set(event.pointerId, now);
    if (others.length > 0) host.setPlace(pinched(host, last, now, others[0]!));
    else if (event.shiftKey || (event.buttons & 2) !== 0) {
      const scale = host.mmPerPixel();
      host.setPlace(shifted(host.place(), (last.x - now.x) * scale, (now.y - last.y) * scale));
    } else host.setPlace(turned(host.place(), (last.x - now.x) * 0.4, (now.y - last.y) * 0.4));
  };
  const up = (event: PointerEvent): void => {
    if (pointers.delete(event.pointerId) && pointers.size === 0) host.moving(false);
  };
  const wheel = (event: WheelEvent): void => {
    event.preventDefault();
    host.moving(true);
    window.clearTimeout(wheelEnd);
    wheelEnd = window.setTimeout(() => host.moving(false), 200);
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1);
    host.setPlace(zoomed(host.place(), Math.exp(Math.max(-120, Math.min(120, pixels)) * 0.0015)));
  };
  const key = (event: KeyboardEvent): void => {
    if (event.target !== element || event.ctrlKey || event.altKey || event.metaKey) return;
    const place = keyed(host.place(), event.key);
    if (!place) return;
    event.preventDefault();
    host.setPlace(place);
  };

  element.addEventListener('pointerdown', down, { signal });
  element.addEventListener('pointermove', move, { signal });
  element.addEventListener('pointerup', up, { signal });
  element.addEventListener('pointercancel', up, { signal });
  element.addEventListener('wheel', wheel, { signal, passive: false });
  element.addEventListener('keydown', key, { signal });
  element.addEventListener('contextmenu', (event) => event.preventDefault(), { signal });
  return () => {
    window.clearTimeout(wheelEnd);
    ends.abort();
  };
}

/** One of two fingers went from `last` to `now` while the other stayed. */
function pinched(host: OrbitHost, last: { x: number; y: number }, now: { x: number; y: number }, other: { x: number; y: number }): CameraPlace {
  const before = Math.max(10, Math.hypot(last.x - other.x, last.y - other.y));
  const after = Math.max(10, Math.hypot(now.x - other.x, now.y - other.y));
  const scale = host.mmPerPixel() / 2;
  return zoomed(shifted(host.place(), (last.x - now.x) * scale, (now.y - last.y) * scale), before / after);
}
