// The prescription: both eyes, with what is wrong or worth asking said beside the form.
import { h, replace } from '../../core/dom';
import { button, newId } from '../../core/ui';
import { tGlasses } from '../../words/glasses';
import type { Desk } from './desk';
import { checkPrescription, eyeFields, textOf, vertexRange, type CheckedPrescription, type Eye, type EyeField, type Finding, type PrescriptionText } from './prescription';
import type { Panel } from './shape_panel';

const eyes: readonly Eye[] = ['right', 'left'];
const fields = Object.keys(eyeFields) as EyeField[];

export function prescriptionForm(desk: Desk): Panel {
  const inputs = new Map<string, HTMLInputElement>();
  const findings = h('ul', { class: 'findings', 'aria-live': 'polite' });
  const input = (where: string, label: string, attributes: object = {}): HTMLInputElement => {
    const element = h('input', { type: 'text', inputmode: 'text', autocomplete: 'off', 'aria-label': label, ...attributes, oninput: () => void checkNow() });
    inputs.set(where, element);
    return element;
  };
  const labelled = (where: string, label: string, attributes: object = {}): HTMLElement => {
    const id = newId('rx');
    return h('div', { class: 'field' }, h('label', { for: id }, label), input(where, label, { id, ...attributes }));
  };
  const table = h('table', { class: 'rx' },
    h('caption', { class: 'hidden-text' }, tGlasses('prescription')),
    h('thead', null, h('tr', null, h('td'), ...eyes.map((eye) => h('th', { scope: 'col' }, tGlasses(eye))))),
    h('tbody', null, ...fields.map((field) =>
      h('tr', null, h('th', { scope: 'row' }, tGlasses(`rx_${field}`), h('span', { class: 'unit' }, ` ${eyeFields[field].unit}`)),
        ...eyes.map((eye) => h('td', null, input(`${eye}.${field}`, `${tGlasses(eye)} ${tGlasses(`rx_${field}`)}`)))))));
  const typed = (): PrescriptionText => textFrom(inputs);
  const checkNow = (): CheckedPrescription => {
    const checked = checkPrescription(typed());
    showFindings(checked.findings, inputs, findings);
    return checked;
  };
  const use = button(tGlasses('rx_use'), () => {
    const { prescription } = checkNow();
    if (prescription) desk.change(tGlasses('prescription'), null, (bench) => ({ ...bench, prescription }));
  }, { kind: 'primary' });
  const none = button(tGlasses('rx_none'), () => desk.change(tGlasses('rx_none'), null, (bench) => ({ ...bench, prescription: null })));
  let shown: unknown = undefined;
  const show = (): void => {
    const { prescription } = desk.bench.value;
    none.disabled = prescription === null;
    if (prescription === shown) return;
    shown = prescription;
    fill(inputs, textOf(prescription, new Date().toISOString().slice(0, 10)));
    replace(findings);
  };
  const root = h('form', { class: 'stack', onsubmit: (event: Event) => event.preventDefault() },
    table,
    h('div', { class: 'two' }, labelled('vertex', tGlasses('rx_vertex', vertexRange)), labelled('date', tGlasses('rx_date_label'), { type: 'date' })),
    labelled('prescriber', tGlasses('rx_prescriber_label')),
    labelled('confirmed_by', tGlasses('rx_confirmed_by')),
    findings, h('div', { class: 'row' }, use, none));
  // Only now are all fields there to be filled.
  const end = desk.bench.watch(show);
  return {
    show,
    root,
    end,
  };
}

function textFrom(inputs: Map<string, HTMLInputElement>): PrescriptionText {
  const of = (where: string): string => inputs.get(where)?.value ?? '';
  const eye = (one: Eye): PrescriptionText['right'] => Object.fromEntries(fields.map((field) => [field, of(`${one}.${field}`)])) as PrescriptionText['right'];
  return { date: of('date'), prescriber: of('prescriber'), vertex: of('vertex'), confirmed_by: of('confirmed_by'), right: eye('right'), left: eye('left') };
}

function fill(inputs: Map<string, HTMLInputElement>, text: PrescriptionText): void {
  const put = (where: string, value: string): void => {
    const input = inputs.get(where);
    if (input) input.value = value;
  };
  for (const key of ['date', 'prescriber', 'vertex', 'confirmed_by'] as const) put(key, text[key]);
  for (const eye of eyes) for (const field of fields) put(`${eye}.${field}`, text[eye][field]);
}

function showFindings(list: Finding[], inputs: Map<string, HTMLInputElement>, into: HTMLElement): void {
  for (const input of inputs.values()) input.removeAttribute('aria-invalid');
  for (const finding of list) if (finding.kind === 'error') inputs.get(finding.where)?.setAttribute('aria-invalid', 'true');
  replace(into, ...list.map((finding) => h('li', { class: finding.kind }, `${whereText(finding.where)}: ${tGlasses(finding.word, finding.values)}`)));
}

function whereText(where: string): string {
  const [eye, field] = where.split('.') as [string, EyeField | undefined];
  if (field) return `${tGlasses(eye as Eye)} ${tGlasses(`rx_${field}`)}`;
  const words: Record<string, string> = { date: tGlasses('rx_date_label'), prescriber: tGlasses('rx_prescriber_label'), vertex: tGlasses('rx_vertex', vertexRange) };
  return words[where] ?? where;
}
