// The configuration: read, searched, and a changed text checked. It is put in force at the machine, by hand.
import { get, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { button, field, newId, table } from '../../core/ui';
import { t } from '../../words/technician';
import { badge, card, loadInto, pageOf } from './page_parts';
import { type ConfigKey, matchingKeys, type Parameters, valueText } from './parameter_filter';
import './technician.css';

interface CheckAnswer {
  ok: boolean;
  error: { line?: number | null; attempted?: string; seen?: string; advice?: string } | null;
}

export const parametersPage = {
  mount(root: HTMLElement): () => void {
    const body = h('div', { class: 'stack' });
    pageOf(root, t('parameters_title'), h('p', null, t('parameters_explain')), body);
    void loadInto(body, () => get<Parameters>('/api/technician/parameters'), (answer) => replace(body, ...drawn(answer)));
    return () => {};
  },
};

function drawn(parameters: Parameters): Node[] {
  const list = h('div', { class: 'stack' });
  const search = field(t('parameters_search'), 'search');
  const draw = () => replace(list, ...sectionTables(parameters, search.value));
  search.input.addEventListener('input', draw);
  draw();
  return [h('p', null, t('file'), ' ', h('code', null, parameters.path)), h('div', { class: 'parameters-layout' }, h('div', { class: 'stack' }, search.root, list), editor(parameters))];
}

function sectionTables(parameters: Parameters, typed: string): Node[] {
  const found = matchingKeys(parameters.sections, typed);
  if (found.length === 0) return [h('p', { class: 'note' }, t('nothing_found'))];
  return found.map(
    ({ name, values }) =>
      table(
        `[${name}]`,
        [
          { head: t('key'), cell: (one: ConfigKey) => h('code', null, one.key) },
          { head: t('value'), cell: (one) => h('code', null, valueText(one.value)) },
          { head: t('comes_from'), cell: (one) => (one.source !== 'file' ? badge(t('from_default')) : badge(one.line ? t('from_line', { n: one.line }) : t('from_file'), 'good')) },
        ],
        values,
      ).root,
  );
}

/** A text with numbered lines; the line of an error is marked. */
function editor(parameters: Parameters): HTMLElement {
  const id = newId('text');
  const area = h('textarea', { id, class: 'code', rows: 22, spellcheck: 'false', autocomplete: 'off', autocapitalize: 'off', wrap: 'off', 'aria-describedby': `${id}-answer` });
  area.value = parameters.text;
  const gutter = h('pre', { class: 'gutter', 'aria-hidden': 'true' });
  const answer = h('div', { id: `${id}-answer`, 'aria-live': 'polite' });
  let bad: number | null = null;
  const number = () => {
    const lines = area.value.split('\n').length;
    replace(gutter, ...Array.from({ length: lines }, (_, k) => h('span', { class: k + 1 === bad ? 'bad-line' : '' }, k + 1 === bad ? `▲${k + 1}\n` : `${k + 1}\n`)));
    gutter.scrollTop = area.scrollTop;
  };
  area.addEventListener('input', () => {
    bad = null;
    area.removeAttribute('aria-invalid');
    replace(answer);
    number();
  });
  area.addEventListener('scroll', () => (gutter.scrollTop = area.scrollTop));
  const check = async () => {
    const told = await post<CheckAnswer>('/api/technician/parameters/check', { text: area.value });
    bad = told.ok ? null : (told.error?.line || null);
    number();
    if (told.ok) return replace(answer, h('p', { class: 'note good' }, `✓ ${t('text_good')}`));
    area.setAttribute('aria-invalid', 'true');
    replace(answer, errorOf(told.error, bad));
    if (bad !== null) showLine(area, bad);
  };
  number();
  return card(
    t('check_text'),
    h('p', { class: 'muted' }, t('check_explain')),
    h('div', { class: 'field' }, h('label', { for: id }, t('text_label')), h('div', { class: 'editor' }, gutter, area)),
    answer,
    h('div', { class: 'row' }, button(t('check_text'), check, { kind: 'primary' }), button(t('as_in_force'), () => {
      area.value = parameters.text;
      area.dispatchEvent(new Event('input'));
    })),
  );
}

function errorOf(error: CheckAnswer['error'], line: number | null): HTMLElement {
  const where = line === null ? '' : `${t('line_n', { n: line })}: `;
  return h('p', { class: 'note bad', role: 'alert' }, h('strong', null, `▲ ${where}${error?.seen ?? ''}`), error?.advice ? h('br') : null, error?.advice);
}

/** Selects a line and brings it into view. */
function showLine(area: HTMLTextAreaElement, line: number): void {
  const lines = area.value.split('\n');
  const start = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
  area.focus();
  area.setSelectionRange(start, start + (lines[line - 1]?.length ?? 0));
  area.scrollTop = Math.max(0, (area.scrollHeight / lines.length) * (line - 6));
}
