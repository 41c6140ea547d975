// The released body, neutral, with lines of measurements and their labels.
import { getBinary } from '../../core/api';
import { h } from '../../core/dom';
import { button } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { readMesh } from '../../view3d/mesh_format';
import type { Vec3 } from '../../view3d/mesh_pick';
import { Viewer, type ViewName } from '../../view3d/viewer';

const colours = ['#0b62d6', '#b3261e', '#1b7a3d', '#8a4b00', '#7b2cbf', '#00707a'];
const views: [ViewName, 'view_front' | 'view_left' | 'view_right' | 'view_back'][] = [
  ['front', 'view_front'],
  ['left45', 'view_left'],
  ['right45', 'view_right'],
  ['back', 'view_back'],
];

export interface DrawnLine {
  id: string;
  curve: Vec3[];
  label: string;
}

export class BodyPicture {
  readonly #viewer: Viewer;
  readonly #tools: HTMLElement;
  #end = false;

  constructor(host: HTMLElement) {
    const stage = h('div', { class: 'body-stage' });
    this.#tools = h('div', { class: 'row' }, ...views.map(([view, name]) => button(t(name), () => this.#viewer.view(view))));
    host.append(stage, this.#tools);
    this.#viewer = new Viewer(stage, { label: t('measures_view'), unavailable: t('grow_no_view') });
  }

  /** @throws ApiFailure 403 until the customer has released it; MeshDamaged. */
  async load(scanId: string): Promise<void> {
    const answer = await getBinary(`/api/scans/${encodeURIComponent(scanId)}/mesh`);
    const mesh = readMesh(await answer.arrayBuffer());
    if (this.#end) return;
    this.#viewer.setMesh('body', mesh, { colour: { body: [0.68, 0.71, 0.74, 1] } });
    this.#viewer.frame();
  }

  draw(lines: readonly DrawnLine[]): void {
    this.#viewer.clear('line.');
    lines.forEach((line, k) => {
      this.#viewer.setLine(`line.${line.id}`, line.curve, { colour: colours[k % colours.length] ?? '#0b62d6', width_px: 3, through: true });
      const place = rightmost(line.curve);
      if (place) this.#viewer.setLabel(`line.${line.id}`, place, line.label);
    });
  }

  dispose(): void {
    this.#end = true;
    this.#viewer.dispose();
    this.#tools.remove();
  }
}

/** Where a label does not hide the body: at the right side of the picture as it is seen from the front. */
function rightmost(curve: readonly Vec3[]): Vec3 | null {
  let found: Vec3 | null = null;
  for (const point of curve) if (!found || point[0] < found[0]) found = point;
  return found;
}
