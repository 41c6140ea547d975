// The customer's head with one or two designs on it; both pictures are looked at from the same side.
import { textOf } from '../../core/ui';
import { h } from '../../core/dom';
import { tGlasses } from '../../words/glasses';
import { boundsOf, type StationMesh } from '../../view3d/mesh_format';
import { Viewer, type CameraPlace, type ViewName } from '../../view3d/viewer';
import type { PreviewNotes } from './api';
import type { Design } from './design';
import type { Desk, Side } from './desk';
import { NewestOnly } from './newest_only';

interface Booth {
  root: HTMLElement;
  viewer: Viewer;
  feed: NewestOnly<Design, { mesh: StationMesh; notes: PreviewNotes }>;
  asked: Design | null;
}

/** Of a face with what is around it. */
const facesHeight_mm = 290;

export class Stage {
  readonly root = h('div', { class: 'stage' });
  readonly #booths = new Map<Side, Booth>();
  readonly #ends: (() => void)[];
  #head: StationMesh | null = null;
  #aimed = false;

  constructor(private readonly desk: Desk) {
    this.#ends = [desk.bench.watch(() => this.#follow())];
  }

  /** The surface that frames are put on. */
  setHead(head: StationMesh): void {
    this.#head = head;
    for (const booth of this.#booths.values()) showHead(booth.viewer, head);
  }

  /** Turns to a named view, in both pictures. */
  view(name: ViewName): void {
    this.#booths.get('a')?.viewer.view(name);
  }

  camera(): CameraPlace | null {
    return this.#booths.get('a')?.viewer.camera() ?? null;
  }

  end(): void {
    for (const end of this.#ends) end();
    for (const side of [...this.#booths.keys()]) this.#close(side);
  }

  /** The face fills the picture: what is looked at is the front of the glasses. */
  #aim(glasses: StationMesh): void {
    const bounds = boundsOf(glasses);
    if (!bounds) return;
    this.#aimed = true;
    const middle = (axis: 0 | 1 | 2): number => (bounds.low[axis] + bounds.high[axis]) / 2;
    this.#booths.get('a')?.viewer.lookAt([middle(0), middle(1), middle(2) - 5], facesHeight_mm);
  }

  #follow(): void {
    const { a, b, active } = this.desk.bench.value;
    this.#show('a', a);
    if (b) this.#show('b', b);
    else this.#close('b');
    this.root.classList.toggle('split', b !== null);
    for (const [side, booth] of this.#booths) {
      booth.root.classList.toggle('active', b !== null && side === active);
      booth.root.querySelector('button')?.setAttribute('aria-pressed', String(side === active));
    }
  }

  #show(side: Side, design: Design): void {
    const booth = this.#booths.get(side) ?? this.#open(side);
    if (booth.asked === design) return;
    booth.asked = design;
    booth.feed.ask(design);
  }

  #open(side: Side): Booth {
    const name = tGlasses(side === 'a' ? 'design_a' : 'design_b');
    const status = h('p', { class: 'stage-status', role: 'status' });
    const root = h('section', { class: 'booth', 'aria-label': name },
      h('button', { type: 'button', class: 'booth-name', onclick: () => this.desk.activate(side) }, name));
    this.root.append(root);
    const viewer = new Viewer(root, { label: `${name}. ${tGlasses('view_label')}`, unavailable: tGlasses('unavailable') });
    root.append(status);
    const feed = new NewestOnly(
      (design: Design) => this.desk.api.preview(design),
      ({ mesh, notes }) => {
        viewer.setMesh('glasses', mesh, notes.textures ? { textures: { parts: [notes.textures.upper, notes.textures.lower], place: notes.textures.frame_from_station } } : {});
        if (!this.#aimed) this.#aim(mesh);
        status.textContent = '';
        this.desk.notes.set({ ...this.desk.notes.value, [side]: notes });
      },
      (error) => {
        status.textContent = tGlasses('preview_failed', { why: [textOf(error).seen, textOf(error).advice].filter(Boolean).join('. ') });
      },
    );
    const booth: Booth = { root, viewer, feed, asked: null };
    this.#booths.set(side, booth);
    viewer.onCamera((place) => {
      for (const [other, one] of this.#booths) if (other !== side) one.viewer.setCamera(place, 'quiet');
    });
    root.addEventListener('pointerdown', () => this.desk.activate(side));
    if (this.#head) showHead(viewer, this.#head);
    const first = this.#booths.get('a')?.viewer;
    if (side === 'b' && first) viewer.setCamera(first.camera(), 'quiet');
    return booth;
  }

  #close(side: Side): void {
    const booth = this.#booths.get(side);
    if (!booth) return;
    booth.feed.end();
    booth.viewer.dispose();
    booth.root.remove();
    this.#booths.delete(side);
  }
}

function showHead(viewer: Viewer, head: StationMesh): void {
  viewer.setMesh('head', head, { knowledge: true });
}
