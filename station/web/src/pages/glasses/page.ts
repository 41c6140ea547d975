// The glasses designer (paper 000, §6) on the customer's own head.
import { get } from '../../core/api';
import { h, replace } from '../../core/dom';
import type { Page } from '../../core/page';
import { button, failurePanel, tabs } from '../../core/ui';
import { adjustedWords, placementWords, tGlasses } from '../../words/glasses';
import { GlassesApi } from './api';
import { Desk } from './desk';
import { fitPanel } from './fit_panel';
import { lensPanel } from './lens_panel';
import { libraryPanel } from './library_panel';
import { lookPanel } from './look_panel';
import { picturesOver } from './pictures';
import type { Prescription } from './prescription';
import { savedPanel } from './saved_panel';
import { shapePanel, type Panel } from './shape_panel';
import { Stage } from './stage';
import { fillWindow } from './fill_window';
import './glasses.css';

export const glassesPage: Pick<Page, 'mount'> = {
  mount(root, { scan = '' }) {
    let end = (): void => {};
    let left = false;
    const begin = async (): Promise<void> => {
      replace(root, h('p', { class: 'muted' }, tGlasses('loading')));
      try {
        const api = new GlassesApi(scan);
        const [catalogue, prescription] = await Promise.all([api.catalogue(), prescriptionOf(scan)]);
        if (left) return;
        end = open(root, new Desk(api, catalogue, prescription, tGlasses('first_step')));
      } catch (error) {
        if (!left) replace(root, failurePanel(error, () => void begin()));
      }
    };
    void begin();
    return () => {
      left = true;
      end();
    };
  },
};

/** What is kept with the customer; null if there is none. */
async function prescriptionOf(scan: string): Promise<Prescription | null> {
  const { customer_id } = await get<{ customer_id: string | null }>(`/api/scans/${encodeURIComponent(scan)}`);
  if (!customer_id) return null;
  return (await get<{ prescription: Prescription | null }>(`/api/customers/${encodeURIComponent(customer_id)}`)).prescription;
}

function open(root: HTMLElement, desk: Desk): () => void {
  const stage = new Stage(desk);
  const pictures = picturesOver(desk, stage);
  const panels = { shape: shapePanel(desk), look: lookPanel(desk), lenses: lensPanel(desk), library: libraryPanel(desk), fit: fitPanel(desk), saved: savedPanel(desk) };
  const keys = Object.keys(panels) as (keyof typeof panels)[];
  const notes = h('div', { class: 'adjusted', 'aria-live': 'polite' });
  const side = tabs(tGlasses('designer'), keys.map((key) => ({ label: tGlasses(key === 'saved' ? 'saved' : key), panel: () => opened(panels[key]) })));
  const designer = h('div', { class: 'designer' },
    h('div', { class: 'designer-main' }, h('h1', { class: 'hidden-text', tabindex: -1 }, tGlasses('designer')), toolbar(desk, stage, pictures), stage.root, pictures.root, notes),
    h('aside', { class: 'designer-side', 'aria-label': tGlasses('designer') }, side));
  replace(root, designer);
  const offSize = fillWindow(designer);
  const offKeys = watchKeys(desk);
  const offNotes = desk.notes.watch((all) => {
    const { adjusted, placement, placement_text, size } = all[desk.side];
    replace(notes, size ? h('span', { class: 'badge' }, size) : null, placement_text ? h('span', { class: 'muted small' }, placementWords(placement, placement_text)) : null,
      adjusted.length > 0 ? h('div', { class: 'note warn' }, h('strong', null, tGlasses('adjusted')), h('ul', null, ...adjusted.map((line) => h('li', null, adjustedWords(line))))) : null);
  });
  desk.api.head().then((head) => stage.setHead(head), (error: unknown) => replace(notes, failurePanel(error)));
  return () => {
    offSize();
    offKeys();
    offNotes();
    pictures.end();
    stage.end();
    for (const key of keys) panels[key].end();
  };
}

function opened(panel: Panel): HTMLElement {
  panel.show();
  return panel.root;
}

function toolbar(desk: Desk, stage: Stage, pictures: { here(): void; three(): void }): HTMLElement {
  const undo = button(tGlasses('undo'), () => desk.undo());
  const redo = button(tGlasses('redo'), () => desk.redo());
  const split = button(tGlasses('split'), () => {
    desk.change(tGlasses(desk.bench.value.b ? 'split_end' : 'split'), null, (bench) =>
      bench.b ? { ...bench, a: bench.active === 'b' ? bench.b : bench.a, b: null, active: 'a' } : { ...bench, b: { ...bench.a }, active: 'b' });
  });
  desk.bench.watch((bench) => {
    undo.disabled = !desk.history.canUndo();
    redo.disabled = !desk.history.canRedo();
    split.textContent = tGlasses(bench.b ? 'split_end' : 'split');
  });
  return h('div', { class: 'toolbar', role: 'toolbar', 'aria-label': tGlasses('designer') },
    undo, redo,
    button(tGlasses('front'), () => stage.view('front')),
    button(tGlasses('from_left'), () => stage.view('left45')),
    button(tGlasses('from_right'), () => stage.view('right45')),
    split,
    button(tGlasses('picture'), () => pictures.here(), { kind: 'primary' }),
    button(tGlasses('picture_three'), () => pictures.three()));
}

/** Ctrl+Z undoes, Ctrl+Y and Ctrl+Shift+Z redo; not while a text is typed, whose own undo this is. */
function watchKeys(desk: Desk): () => void {
  const listener = (event: KeyboardEvent): void => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const target = event.target as HTMLElement | null;
    const typing = target instanceof HTMLTextAreaElement || (target instanceof HTMLInputElement && ['text', 'date', 'search'].includes(target.type));
    const key = event.key.toLowerCase();
    const back = key === 'z' && !event.shiftKey;
    const forth = key === 'y' || (key === 'z' && event.shiftKey);
    if (typing || (!back && !forth)) return;
    event.preventDefault();
    if (back) desk.undo();
    else desk.redo();
  };
  addEventListener('keydown', listener);
  return () => removeEventListener('keydown', listener);
}
