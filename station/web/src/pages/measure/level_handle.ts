// A handle beside the body that is drawn up and down to a height.
import { h } from '../../core/dom';
import { towardsCamera } from '../../view3d/orbit';
import type { Vec3 } from '../../view3d/mesh_pick';
import type { Bench } from './tool';

export class LevelHandle {
  readonly #handle: HTMLButtonElement;
  #z_mm = 0;
  #offset_px = 0;
  #held = false;
  #unwatch = (): void => {};

  /** `moved` is told of every height (mm) that it is drawn to, within the model's. */
  constructor(
    private readonly bench: Bench,
    private readonly id: string,
    label: string,
    letter: string,
    private readonly moved: (z_mm: number) => void,
  ) {
    this.#handle = h('button', {
      type: 'button',
      class: 'cursor-handle level',
      'aria-label': label,
      onpointerdown: (event: PointerEvent) => this.#grab(event),
      onpointermove: (event: PointerEvent) => this.#drag(event),
      onpointerup: () => (this.#held = false),
      onpointercancel: () => (this.#held = false),
      onkeydown: (event: KeyboardEvent) => this.#key(event),
    }, letter);
  }

  /** The handle stays at the same side of the picture while the camera turns. */
  begin(): void {
    this.#unwatch = this.bench.viewer.onCamera(() => this.show(this.#z_mm));
  }

  end(): void {
    this.#unwatch();
    this.bench.viewer.setMark(this.id, null);
  }

  show(z_mm: number): void {
    this.#z_mm = z_mm;
    this.bench.viewer.setMark(this.id, { position: this.#beside(z_mm), element: this.#handle, kind: 'handle' });
  }

  /** To the viewer's right of the body's axis, a third of the picture's width away. */
  #beside(z_mm: number): Vec3 {
    const { viewer } = this.bench;
    const place = viewer.camera();
    const [outX, outY] = towardsCamera({ ...place, elevation_deg: 0 });
    const away = 0.36 * viewer.element.clientWidth * viewer.mmPerPixel();
    return [place.target[0] - outY * away, place.target[1] + outX * away, z_mm];
  }

  #grab(event: PointerEvent): void {
    event.stopPropagation();
    this.#handle.setPointerCapture(event.pointerId);
    this.#held = true;
    const box = this.#handle.getBoundingClientRect();
    this.#offset_px = event.clientY - (box.top + box.height / 2);
  }

  #drag(event: PointerEvent): void {
    if (!this.#held) return;
    event.stopPropagation();
    const { viewer } = this.bench;
    const now = viewer.project(this.#beside(this.#z_mm));
    if (!now) return;
    const y = event.clientY - this.#offset_px - viewer.element.getBoundingClientRect().top;
    // Heights are foreshortened when looked at from above or below.
    const upright = Math.max(0.2, Math.cos((viewer.camera().elevation_deg * Math.PI) / 180));
    this.#tell(this.#z_mm + ((now.y - y) * viewer.mmPerPixel()) / upright);
  }

  #key(event: KeyboardEvent): void {
    const step = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    this.#tell(this.#z_mm + step * (event.shiftKey ? 10 : 1));
  }

  #tell(z_mm: number): void {
    const held = Math.max(this.bench.low_mm, Math.min(this.bench.high_mm, Math.round(2 * z_mm) / 2));
    if (held !== this.#z_mm) this.moved(held);
  }
}
