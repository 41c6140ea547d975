// What lies over the picture as HTML: labels that never cover each other, and handles that a finger can take.
import { h, svg } from '../core/dom';
import type { Vec3 } from './mesh_pick';

export interface Mark {
  position: Vec3;
  /** Of the surface there; a mark on the side away from the viewer is dimmed. */
  normal?: Vec3;
  element: HTMLElement;
  /** A label stands beside its place with a line to it, a handle on it. */
  kind: 'label' | 'handle';
}

/** Where a place appears: pixels from the upper left corner; null behind the camera. */
export type Project = (position: Vec3) => { x: number; y: number } | null;

interface Rectangle {
  x: number;
  y: number;
  width: number;
  height: number;
}

const gap_px = 4;
const beside_px = 18;
/** What is seen of a handle, across. */
const handle_px = 28;

/**
 * Puts labels beside their anchors, from the top down, each below what it would cover.
 * `anchors` are in the order of the answer; all stay within width × height as far as there is room. `taken`: what no
 * label may cover.
 */
export function layOut(anchors: { x: number; y: number; width: number; height: number }[], width: number, height: number, taken: readonly Rectangle[] = []): Rectangle[] {
  const placed: Rectangle[] = [...taken];
  const order = anchors.map((_, i) => i).sort((a, b) => anchors[a]!.y - anchors[b]!.y);
  const answer: Rectangle[] = new Array<Rectangle>(anchors.length);
  for (const i of order) {
    const anchor = anchors[i]!;
    const right = anchor.x + beside_px + anchor.width <= width;
    const box = {
      x: Math.max(0, right ? anchor.x + beside_px : anchor.x - beside_px - anchor.width),
      y: Math.max(0, Math.min(anchor.y - anchor.height / 2, height - anchor.height)),
      width: anchor.width,
      height: anchor.height,
    };
    for (let hit = covered(placed, box); hit; hit = covered(placed, box)) box.y = hit.y + hit.height + gap_px;
    if (box.y + box.height > height) {
      box.y = Math.max(0, height - box.height);
      for (let hit = covered(placed, box); hit && hit.y - gap_px - box.height >= 0; hit = covered(placed, box)) box.y = hit.y - gap_px - box.height;
    }
    placed.push(box);
    answer[i] = box;
  }
  return answer;
}

function covered(placed: Rectangle[], box: Rectangle): Rectangle | undefined {
  return placed.find(
    (other) => box.x < other.x + other.width && other.x < box.x + box.width && box.y < other.y + other.height && other.y < box.y + box.height,
  );
}

/** The marks of one picture. */
export class Overlay {
  readonly element = h('div', { class: 'view3d-overlay' });
  readonly #lines = svg('svg', { class: 'view3d-leaders', 'aria-hidden': 'true' });
  readonly #marks = new Map<string, Mark & { width: number; height: number; line: SVGElement | null }>();
  #placeAgain = (): void => {};

  constructor() {
    this.element.append(this.#lines);
  }

  /** Puts, changes or (null) takes away a mark. */
  set(id: string, mark: Mark | null): void {
    const old = this.#marks.get(id);
    if (old && old.element !== mark?.element) old.element.remove();
    if (!mark) {
      old?.line?.remove();
      this.#marks.delete(id);
      return;
    }
    mark.element.classList.add('view3d-mark', `view3d-${mark.kind}`);
    if (mark.element.parentNode !== this.element) this.element.append(mark.element);
    const line = mark.kind === 'label' ? (old?.line ?? this.#lines.appendChild(svg('line'))) : null;
    this.#marks.set(id, { ...mark, width: mark.element.offsetWidth, height: mark.element.offsetHeight, line });
    // At once: a hand may reach for it before the next picture is drawn.
    this.#placeAgain();
  }

  ids(): string[] {
    return [...this.#marks.keys()];
  }

  /** Lays all marks out for a camera at `eye`. */
  place(project: Project, eye: Vec3, width: number, height: number): void {
    this.#placeAgain = () => this.place(project, eye, width, height);
    const handles: Rectangle[] = [];
    const labels: { mark: Mark & { line: SVGElement | null }; x: number; y: number; width: number; height: number }[] = [];
    for (const mark of this.#marks.values()) {
      const at = project(mark.position);
      const shown = at !== null && at.x >= 0 && at.y >= 0 && at.x <= width && at.y <= height;
      mark.element.hidden = !shown;
      mark.line?.classList.toggle('off', !shown);
      if (!shown) continue;
      mark.element.classList.toggle('away', facesAway(mark, eye));
      if (mark.kind === 'handle') {
        mark.element.style.transform = `translate(${at.x}px, ${at.y}px) translate(-50%, -50%)`;
        handles.push({ x: at.x - handle_px / 2, y: at.y - handle_px / 2, width: handle_px, height: handle_px });
      } else {
        if (mark.width === 0) [mark.width, mark.height] = [mark.element.offsetWidth, mark.element.offsetHeight];
        labels.push({ mark, ...at, width: mark.width, height: mark.height });
      }
    }
    layOut(labels, width, height, handles).forEach((box, i) => {
      const { mark, x, y } = labels[i]!;
      mark.element.style.transform = `translate(${box.x}px, ${box.y}px)`;
      const end = box.x > x ? box.x : box.x + box.width;
      for (const [name, value] of Object.entries({ x1: x, y1: y, x2: end, y2: box.y + box.height / 2 })) mark.line?.setAttribute(name, String(value));
    });
  }
}

function facesAway(mark: Mark, eye: Vec3): boolean {
  if (!mark.normal) return false;
  return mark.normal.reduce((sum, value, axis) => sum + value * (eye[axis]! - mark.position[axis]!), 0) < 0;
}
