// Shape: the eight sliders of paper 000, fig. 22, style, size, and what the paper leaves out.
import { h, replace } from '../../core/dom';
import { button, choice } from '../../core/ui';
import { tGlasses, fieldWord, frameWord, styleWord } from '../../words/glasses';
import type { FrameField } from './api';
import { hexOf } from './colour';
import { sliderRow, type SliderRow } from './controls';
import { activeDesign, halfOf, type Design } from './design';
import type { Desk } from './desk';
import { drawingBox, frameDrawing } from './frame_drawing';

export interface Panel {
  root: HTMLElement;
  /** Brings it up to date: called when it is opened. While it is closed it costs nothing. */
  show(): void;
  /** Ends what the panel watches. */
  end(): void;
}

/** `show`, as a watcher that does nothing while the panel is closed. */
export function whileOpen(root: HTMLElement, show: () => void): () => void {
  return () => {
    if (root.isConnected) show();
  };
}

export function shapePanel(desk: Desk): Panel {
  const drawing = drawingBox();
  const style = choice(tGlasses('style'), 'style', desk.catalogue.styles.map((one) => [one.id, styleWord(one.id, one.name)] as const), '');
  const sizes = h('div');
  style.input.addEventListener('change', () => {
    desk.changeDesign(tGlasses('step_style'), null, (design) => ({ ...design, style: style.input.value, size: '', fields: {} }));
  });
  const sliders = new Map(desk.catalogue.sliders.map((field) => [field.id, fieldSlider(desk, field)] as const));
  const asStyle = button(tGlasses('as_style'), () => desk.changeDesign(tGlasses('as_style'), null, (design) => ({ ...design, fields: {} })), { kind: 'quiet' });
  const details = detailFields(desk);
  const show = (): void => {
    const design = activeDesign(desk.bench.value);
    const values = desk.values(design, desk.notes.value[desk.side]);
    style.input.value = design.style;
    showSizes(desk, design, sizes);
    for (const [id, row] of sliders) if (typeof values[id] === 'number') row.set(values[id]);
    details.show(values);
    asStyle.disabled = Object.keys(design.fields).length === 0;
    const colours = { upper: hexOf(halfOf(design.look, 'upper').colour.base), lower: hexOf(halfOf(design.look, 'lower').colour.base), lens: hexOf(design.look.lens.tint.base) };
    replace(drawing, frameDrawing(values, colours, tGlasses('drawing_label')));
  };
  const root = h('div', { class: 'stack' }, drawing, h('div', { class: 'two' }, style.root, sizes),
    ...[...sliders.values()].map((row) => row.root), asStyle,
    h('details', { class: 'more' }, h('summary', null, tGlasses('more_shape')), details.root));
  const ends = [desk.bench.watch(whileOpen(root, show)), desk.notes.watch(whileOpen(root, show))];
  return {
    root,
    show,
    end: () => ends.forEach((end) => end()),
  };
}

function fieldSlider(desk: Desk, field: FrameField): SliderRow {
  const label = fieldWord(field.id, field.label);
  const look = {
    low: field.low ?? 0,
    high: field.high ?? 1,
    step: field.step ?? 0.1,
    unit: field.unit === 'deg' ? '°' : field.unit,
    ...(field.low_word && { lowWord: frameWord(field.low_word), highWord: frameWord(field.high_word ?? '') }),
  };
  return sliderRow(
    label,
    look,
    (value) => desk.changeDesign(label, field.id, (design) => ({ ...design, fields: { ...design.fields, [field.id]: value } })),
    () => desk.settle(),
  );
}

function showSizes(desk: Desk, design: Design, into: HTMLElement): void {
  const sizes = desk.style(design.style)?.sizes ?? [];
  const options = [['', tGlasses('size_free')] as const, ...sizes.map((size) => [size.id, size.marking] as const)];
  const key = JSON.stringify([design.style, design.size]);
  if (into.dataset['shown'] === key) return;
  into.dataset['shown'] = key;
  const select = choice(tGlasses('size'), 'size', options, design.size);
  select.input.addEventListener('change', () => {
    desk.changeDesign(tGlasses('size'), null, (one) => ({ ...one, size: select.input.value }));
  });
  replace(into, select.root);
}

/** Everything beyond the eight sliders: forms by word, lengths and angles by number. */
function detailFields(desk: Desk): { root: HTMLElement; show(values: Record<string, number | string | null>): void } {
  const fields = desk.catalogue.details ?? [];
  const rows = new Map<string, (value: number | string | null) => void>();
  const elements = fields.map((field) => {
    if (!field.words) {
      const row = fieldSlider(desk, field);
      rows.set(field.id, (value) => typeof value === 'number' && row.set(value));
      return row.root;
    }
    const select = choice(fieldWord(field.id, field.label), field.id, field.words.map((word) => [word, frameWord(word)] as const), '');
    select.input.addEventListener('change', () => {
      desk.changeDesign(fieldWord(field.id, field.label), null, (design) => ({ ...design, fields: { ...design.fields, [field.id]: select.input.value } }));
    });
    rows.set(field.id, (value) => void (select.input.value = String(value ?? '')));
    return select.root;
  });
  return {
    root: h('div', { class: 'stack' }, ...elements),
    show: (values) => rows.forEach((show, id) => show(values[id] ?? null)),
  };
}
