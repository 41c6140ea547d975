// A spectacle prescription as it is written down in a shop (RX.json of docs/formats.md).
import { h } from '../../core/dom';
import { field, type Field } from '../../core/ui';
import { tOperator as t } from '../../words/operator';

interface Eye {
  sph_d: number;
  cyl_d?: number;
  axis_deg?: number;
  add_d?: number;
  pd_mm?: number;
}

export interface Prescription {
  format: 'annulus-rx';
  version: 1;
  date: string;
  prescriber: string;
  right: Eye;
  left: Eye;
  [other: string]: unknown;
}

const ranges = { sph_d: [-30, 30, 0.25], cyl_d: [-15, 15, 0.25], axis_deg: [0, 180, 1], add_d: [0.25, 4, 0.25], pd_mm: [20, 45, 0.5] } as const;
const names = { sph_d: 'rx_sph', cyl_d: 'rx_cyl', axis_deg: 'rx_axis', add_d: 'rx_add', pd_mm: 'rx_pd' } as const;
type Key = keyof typeof ranges;
const keys = Object.keys(ranges) as Key[];

/** `read()`: the prescription, null if nothing was written, 'bad' if it cannot be right (shown at its field). */
export function prescriptionForm(old: object | null) {
  const known = old as Prescription | null;
  const prescriber = field(t('rx_prescriber'), 'prescriber', { maxlength: 120, value: known?.prescriber ?? '' });
  const day = field(t('rx_date'), 'date', { type: 'date', value: known?.date ?? '' });
  const right = eyeFields('right', known?.right);
  const left = eyeFields('left', known?.left);
  const root = h(
    'details',
    { class: 'card', open: known !== null },
    h('summary', null, t('rx_title')),
    h('div', { class: 'stack' }, h('div', { class: 'columns' }, prescriber.root, day.root), eyeRow(t('rx_right'), right), eyeRow(t('rx_left'), left)),
  );
  return {
    root,
    read(): Prescription | null | 'bad' {
      const all = [prescriber, day, ...keys.flatMap((key) => [right[key], left[key]])];
      for (const one of all) one.error(null);
      if (all.every((one) => one.value === '')) return null;
      const needed = [prescriber, day, right.sph_d, left.sph_d].filter((one) => one.value === '');
      for (const one of needed) one.error(t('rx_needed'));
      const bad = [...needed, ...badNumbers(right), ...badNumbers(left)];
      bad[0]?.input.focus();
      if (bad.length > 0) return 'bad';
      return { ...known, format: 'annulus-rx', version: 1, date: day.value, prescriber: prescriber.value, right: eyeOf(right, known?.right), left: eyeOf(left, known?.left) };
    },
  };
}

function eyeFields(side: string, eye: Eye | undefined): Record<Key, Field> {
  const make = (key: Key) => {
    const [min, max, step] = ranges[key];
    return field(t(names[key]), `${side}.${key}`, { type: 'number', min, max, step, inputmode: 'decimal', value: eye?.[key] === undefined ? '' : String(eye[key]) });
  };
  return Object.fromEntries(keys.map((key) => [key, make(key)])) as Record<Key, Field>;
}

function eyeRow(title: string, fields: Record<Key, Field>): HTMLElement {
  return h('fieldset', { class: 'eye' }, h('legend', null, title), ...keys.map((key) => fields[key].root));
}

function badNumbers(fields: Record<Key, Field>): Field[] {
  const bad = keys.filter((key) => {
    const [min, max] = ranges[key];
    const text = fields[key].value;
    const wrong = (text === '' && (fields[key].input as HTMLInputElement).validity.badInput) || (text !== '' && !(Number(text) >= min && Number(text) <= max));
    if (wrong) fields[key].error(t('rx_range', { min, max }));
    return wrong;
  });
  if (fields.cyl_d.value !== '' && Number(fields.cyl_d.value) !== 0 && fields.axis_deg.value === '') {
    fields.axis_deg.error(t('rx_axis_needed'));
    bad.push('axis_deg');
  }
  return bad.map((key) => fields[key]);
}

function eyeOf(fields: Record<Key, Field>, old: Eye | undefined): Eye {
  const written = keys.filter((key) => fields[key].value !== '').map((key) => [key, Number(fields[key].value)] as const);
  const kept = Object.fromEntries(Object.entries(old ?? {}).filter(([key]) => !(key in ranges)));
  return { ...kept, ...Object.fromEntries(written) } as unknown as Eye;
}
