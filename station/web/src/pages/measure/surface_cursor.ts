// The surface cursor of paper 001, §3: a mark that moves along the surface under the finger, or by keys along its
// parameters. It follows on the page's own mesh at once; where it really is, the server says.
import { h } from '../../core/dom';
import { NewestOnly } from '../glasses/newest_only';
import type { Ray, Vec3, Viewer } from '../../view3d/viewer';
import type { MeasureApi, Place, SurfacePoint } from './api';

export interface CursorLook {
  /** One letter or a few: what stands on the handle. */
  letter: string;
  /** Read out. */
  label: string;
  /** 'level': only its height can be changed. */
  moves?: 'surface' | 'level';
}

/** Millimetres along the surface for one press of an arrow key; ten times that with Shift. */
const keyStep_mm = 1;

export class SurfaceCursor {
  /** Where it is, as the server confirmed; null before the first place. */
  point: SurfacePoint | null = null;
  /** Told whenever the server has confirmed a new place: while it is dragged, and when it is let go. */
  moved: (point: SurfacePoint, how: 'dragged' | 'settled') => void = () => {};
  failed: (error: unknown) => void = () => {};

  readonly #handle: HTMLButtonElement;
  readonly #picks: NewestOnly<{ what: Ray | Place; settle: boolean }, SurfacePoint | null>;
  #dragging = false;

  constructor(
    private readonly viewer: Viewer,
    api: MeasureApi,
    private readonly id: string,
    private readonly look: CursorLook,
  ) {
    this.#handle = h('button', {
      type: 'button',
      class: 'cursor-handle',
      'aria-label': look.label,
      'aria-keyshortcuts': 'ArrowLeft ArrowRight ArrowUp ArrowDown',
      onpointerdown: (event: PointerEvent) => this.#grab(event),
      onpointermove: (event: PointerEvent) => this.#drag(event),
      onpointerup: (event: PointerEvent) => this.#release(event),
      onpointercancel: (event: PointerEvent) => this.#release(event),
      onkeydown: (event: KeyboardEvent) => this.#key(event),
    }, look.letter);
    this.#picks = new NewestOnly(
      ({ what }) => api.pick(what),
      (point, { settle }) => {
        if (!point) return;
        this.point = point;
        if (!this.#dragging) this.#show(point.position, point.normal);
        this.moved(point, settle ? 'settled' : 'dragged');
      },
      (error) => this.failed(error),
    );
  }

  /** Puts it on a place of the surface, or where a ray meets it. */
  put(what: Ray | Place): void {
    this.#picks.ask({ what, settle: true });
  }

  /** Puts it where the server has already found it. */
  set(point: SurfacePoint): void {
    this.point = point;
    this.#show(point.position, point.normal);
  }

  focus(): void {
    this.#handle.focus();
  }

  remove(): void {
    this.#picks.end();
    this.viewer.setMark(this.id, null);
  }

  #show(position: Vec3, normal: Vec3): void {
    this.viewer.setMark(this.id, { position, normal, element: this.#handle, kind: 'handle' });
  }

  #grab(event: PointerEvent): void {
    event.stopPropagation();
    this.#handle.setPointerCapture(event.pointerId);
    this.#dragging = true;
  }

  #drag(event: PointerEvent): void {
    if (!this.#dragging) return;
    event.stopPropagation();
    const hit = this.viewer.pick('body', event.clientX, event.clientY);
    if (!hit) return;
    this.#show(hit.point, hit.normal);
    this.#picks.ask({ what: this.look.moves === 'level' && this.point ? { theta_deg: this.point.theta_deg, z_mm: hit.point[2] } : placeOf(hit.point), settle: false });
  }

  #release(event: PointerEvent): void {
    if (!this.#dragging) return;
    event.stopPropagation();
    this.#dragging = false;
    const hit = this.viewer.pick('body', event.clientX, event.clientY);
    const what = hit ? placeOf(hit.point) : this.point && { theta_deg: this.point.theta_deg, z_mm: this.point.z_mm };
    if (what) this.#picks.ask({ what, settle: true });
  }

  #key(event: KeyboardEvent): void {
    const step = keyStep_mm * (event.shiftKey ? 10 : 1);
    const along = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
    if (!along || !this.point) return;
    event.preventDefault();
    event.stopPropagation();
    const [across, up] = along as [number, number];
    const radius = Math.max(10, Math.hypot(this.point.position[0], this.point.position[1]));
    const turn = this.look.moves === 'level' ? 0 : ((across / radius) * 180) / Math.PI;
    // Seen from outside, wherever the camera stands, theta grows to the right.
    this.put({ theta_deg: (this.point.theta_deg + turn + 360) % 360, z_mm: this.point.z_mm + up });
  }
}

/** Angle and height of a place of the station frame. */
export function placeOf([x, y, z]: Vec3): Place {
  return { theta_deg: ((Math.atan2(y, x) * 180) / Math.PI + 360) % 360, z_mm: z };
}

/** A press on the surface that is no turning of the camera: calls with where. What is returned ends it. */
export function onSurfaceTap(viewer: Viewer, tapped: (clientX: number, clientY: number) => void): () => void {
  let start: { x: number; y: number; id: number } | null = null;
  const ends = new AbortController();
  const { signal } = ends;
  viewer.element.addEventListener('pointerdown', (event) => {
    start = event.target instanceof HTMLCanvasElement || event.target === viewer.element ? { x: event.clientX, y: event.clientY, id: event.pointerId } : null;
  }, { signal });
  viewer.element.addEventListener('pointerup', (event) => {
    if (start?.id === event.pointerId && Math.hypot(event.clientX - start.x, event.clientY - start.y) < 6) tapped(event.clientX, event.clientY);
    start = null;
  }, { signal });
  return () => ends.abort();
}
