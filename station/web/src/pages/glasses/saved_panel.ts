// Designs that are kept with the scan, and every step since the page was opened.
import { h, replace } from '../../core/dom';
import { button, failurePanel, field } from '../../core/ui';
import { toast } from '../../core/overlay';
import { dateText, tGlasses } from '../../words/glasses';
import type { SavedDesign } from './api';
import { activeDesign, lookOfFile, withDesign, type Design } from './design';
import type { Desk } from './desk';
import { whileOpen, type Panel } from './shape_panel';

export function savedPanel(desk: Desk): Panel {
  const title = field(tGlasses('title'), 'title', { maxlength: 80 });
  const list = h('ul', { class: 'saved-list' });
  const steps = h('ol', { class: 'history' });
  const load = async (): Promise<void> => {
    try {
      const { designs } = await desk.api.designs();
      replace(list, ...designs.map((one) => savedRow(desk, one, () => void load())));
      if (designs.length === 0) replace(list, h('li', { class: 'muted' }, tGlasses('no_designs')));
    } catch (error) {
      replace(list, h('li', null, failurePanel(error, () => void load())));
    }
  };
  const save = button(tGlasses('save'), async () => {
    const name = title.value || dateText(Date.now());
    await desk.api.save(name, activeDesign(desk.bench.value), desk.bench.value.prescription);
    toast(tGlasses('saved_as', { name }), 'good');
    await load();
  }, { kind: 'primary' });
  const showSteps = (): void => {
    const { history } = desk;
    replace(steps, ...history.entries.map((entry, i) =>
      h('li', null, h('button', { type: 'button', class: 'history-step', 'aria-current': i === history.position ? 'step' : null, onclick: () => desk.go(i) }, entry.label))));
    steps.querySelector('[aria-current]')?.scrollIntoView({ block: 'nearest' });
  };
  const root = h('div', { class: 'stack' }, h('div', { class: 'save-line' }, title.root, save), list, h('h3', null, tGlasses('history')), steps);
  const end = desk.bench.watch(whileOpen(root, showSteps));
  return {
    root,
    show: () => {
      showSteps();
      void load();
    },
    end,
  };
}

function savedRow(desk: Desk, saved: SavedDesign, changed: () => void): HTMLElement {
  const take = button(tGlasses('load'), () => {
    desk.change(tGlasses('step_load', { name: saved.title }), null, (bench) => ({ ...withDesign(bench, () => designOf(saved)), prescription: saved.prescription ?? bench.prescription }));
  }, { label: `${tGlasses('load')}: ${saved.title}` });
  const over = button(tGlasses('save_over'), async () => {
    await desk.api.update(saved.id, saved.title, activeDesign(desk.bench.value));
    toast(tGlasses('saved_as', { name: saved.title }), 'good');
    changed();
  }, { kind: 'quiet', label: `${tGlasses('save_over')}: ${saved.title}` });
  const remove = button(tGlasses('remove'), async () => {
    await desk.api.remove(saved.id);
    changed();
  }, { kind: 'quiet', label: `${tGlasses('remove')}: ${saved.title}` });
  return h('li', null, h('div', null, h('strong', null, saved.title), h('span', { class: 'muted small' }, ` ${dateText(saved.made_ms)}`)),
    h('div', { class: 'row' }, take, over, remove));
}

/** A kept design as the bench has it. Numbers may have been kept as texts. */
function designOf(saved: SavedDesign): Design {
  const fields = Object.entries(saved.design.fields ?? {}).map(([name, value]) => {
    const number = typeof value === 'string' && value.trim() !== '' ? Number(value) : NaN;
    return [name, Number.isNaN(number) ? value : number] as const;
  });
  return { style: saved.design.style, size: saved.design.size ?? '', fields: Object.fromEntries(fields), look: lookOfFile(saved.look) };
}
