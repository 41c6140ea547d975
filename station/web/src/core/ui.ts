// Controls that pages are made of: for keyboard, touch and screen readers alike.
import { ApiFailure, type ErrorText } from './api';
import { h } from './dom';
import { toast } from './overlay';
import { tShell } from '../words/shell';

type Child = Node | string | number | null | undefined | false;

let lastId = 0;

/** An id that no other element has: for `aria-describedby` and `for`. */
export function newId(prefix = 'id'): string {
  lastId += 1;
  return `${prefix}-${lastId}`;
}

export interface ButtonLook {
  kind?: 'primary' | 'plain' | 'danger' | 'quiet';
  large?: boolean;
  /** Spoken instead of the text; must contain the text that is seen. */
  label?: string;
  disabled?: boolean;
}

/**
 * A button. While a promise that `act` returns is under way the button cannot be pressed again; an ApiFailure is shown
 * as a toast unless `act` deals with it.
 */
export function button(text: Child | Child[], act: (event: MouseEvent) => unknown, look: ButtonLook = {}): HTMLButtonElement {
  const element = h(
    'button',
    {
      type: 'button',
      class: `button ${look.kind ?? 'plain'}${look.large ? ' large' : ''}`,
      'aria-label': look.label,
      disabled: look.disabled,
      onclick: (event: MouseEvent) => void runBusy(element, () => act(event)),
    },
    ...(Array.isArray(text) ? text : [text]),
  );
  return element;
}

/** A link that looks like a button: `linkButton(t('open'), '/scans/7')`. */
export function linkButton(text: string, path: string, look: ButtonLook = {}): HTMLAnchorElement {
  return h('a', { href: `#${path}`, class: `button ${look.kind ?? 'plain'}${look.large ? ' large' : ''}` }, text);
}

/** Runs `act` with the control disabled until it is done; failures become toasts. */
export async function runBusy(control: HTMLButtonElement, act: () => unknown): Promise<void> {
  const result = act();
  if (!(result instanceof Promise)) return;
  control.disabled = true;
  control.setAttribute('aria-busy', 'true');
  try {
    await result;
  } catch (error) {
    showFailure(error);
  } finally {
    control.disabled = false;
    control.removeAttribute('aria-busy');
  }
}

/** The three parts of an error, whatever was thrown. */
export function textOf(error: unknown): ErrorText {
  if (error instanceof ApiFailure) return error.text;
  return { attempted: '', seen: error instanceof Error ? error.message : String(error), advice: '' };
}

export function showFailure(error: unknown): void {
  if (error instanceof DOMException && error.name === 'AbortError') return;
  const text = textOf(error);
  toast([text.seen, text.advice].filter((part) => part !== '').join(' — '), 'bad');
}

/** What was tried, what happened, what to do; in a page where something could not be done. */
export function failurePanel(error: unknown, again?: () => void): HTMLElement {
  const text = textOf(error);
  const line = (term: string, what: string, kind = '') => (what ? [h('dt', null, term), h('dd', { class: kind }, what)] : []);
  return h(
    'section',
    { class: 'failure stack', role: 'alert' },
    h('h2', null, tShell('something_failed')),
    h(
      'dl',
      null,
      line(tShell('attempted'), text.attempted),
      line(tShell('seen'), text.seen),
      line(tShell('do'), text.advice, 'do'),
    ),
    again ? h('div', { class: 'row' }, button(tShell('retry'), again)) : null,
  );
}

/** What the program itself said, in English, under our words for it: for whoever is called. */
export function ownWords(own: string, shown: string): HTMLElement | null {
  return own && own !== shown ? h('span', { class: 'muted', lang: 'en' }, h('br'), own) : null;
}

export interface FieldLook {
  type?: string;
  value?: string;
  hint?: string;
  required?: boolean;
  autocomplete?: string;
  inputmode?: string;
  maxlength?: number;
  min?: number;
  max?: number;
  step?: number | 'any';
  lines?: number;
}

export interface Field {
  root: HTMLElement;
  input: HTMLInputElement | HTMLTextAreaElement;
  readonly value: string;
  /** Shows what is wrong with it (read out at once), or takes that away. */
  error(text: string | null): void;
}

/** A labelled input with a hint and a place for what is wrong. `name` is the key that the station names in its errors. */
export function field(label: string, name: string, look: FieldLook = {}): Field {
  const id = newId(name);
  const hint = look.hint ? h('span', { class: 'hint', id: `${id}-hint` }, look.hint) : null;
  const error = h('span', { class: 'error', id: `${id}-error`, role: 'alert' });
  const attributes = {
    id,
    name,
    value: look.value,
    required: look.required,
    autocomplete: look.autocomplete ?? 'off',
    inputmode: look.inputmode,
    maxlength: look.maxlength,
    min: look.min,
    max: look.max,
    step: look.step,
    'aria-describedby': hint ? `${id}-hint ${id}-error` : `${id}-error`,
  };
  const input = look.lines ? h('textarea', { ...attributes, rows: look.lines }) : h('input', { ...attributes, type: look.type ?? 'text' });
  return {
    root: h('div', { class: 'field' }, h('label', { for: id }, label), input, hint, error),
    input,
    get value() {
      return input.value.trim();
    },
    error(text) {
      error.textContent = text ?? '';
      if (text) input.setAttribute('aria-invalid', 'true');
      else input.removeAttribute('aria-invalid');
    },
  };
}

/** A labelled choice of few. */
export function choice(label: string, name: string, options: readonly (readonly [value: string, text: string])[], value: string) {
  const id = newId(name);
  const input = h('select', { id, name }, ...options.map(([key, text]) => h('option', { value: key, selected: key === value }, text)));
  return { root: h('div', { class: 'field' }, h('label', { for: id }, label), input), input };
}

export function check(label: string, checked = false, change: (checked: boolean) => void = () => {}) {
  const input = h('input', { type: 'checkbox', checked, onchange: () => change(input.checked) });
  return { root: h('label', { class: 'check' }, input, h('span', null, label)), input };
}

/** Puts a failure at the field that the station names; false if it names none of these. */
export function showAtField(error: unknown, fields: readonly Field[]): boolean {
  for (const one of fields) one.error(null);
  if (!(error instanceof ApiFailure) || !error.field) return false;
  const name = error.field;
  const found = fields.find((one) => one.input.name === name);
  if (!found) return false;
  found.error(`${error.text.seen}. ${error.text.advice}`);
  found.input.focus();
  return true;
}

/** A bar with a label and a line of text below. `set(0.4, 'text')`; null: it is not known how far. */
export function progress(label: string) {
  const bar = h('progress', { max: 1, 'aria-label': label });
  const text = h('span', { class: 'muted' });
  return {
    root: h('div', { class: 'progress' }, h('strong', null, label), bar, text),
    set(share: number | null, line = '') {
      if (share === null) bar.removeAttribute('value');
      else bar.value = Math.min(Math.max(share, 0), 1);
      text.textContent = line;
    },
  };
}

export interface Column<Row> {
  head: string;
  cell(row: Row): Child | Child[];
  number?: boolean;
}

/** A table that scrolls sideways within its frame, with a caption. The first column is the row's head. */
export function table<Row>(caption: string, columns: readonly Column<Row>[], rows: readonly Row[]) {
  const style = (column: Column<Row>) => (column.number ? 'number' : '');
  const cells = (row: Row) =>
    columns.map((column, k) => {
      const content = column.cell(row);
      const list = Array.isArray(content) ? content : [content];
      return k === 0 ? h('th', { scope: 'row', class: style(column) }, ...list) : h('td', { class: style(column) }, ...list);
    });
  const body = h('tbody', null, ...rows.map((row) => h('tr', null, ...cells(row))));
  const head = h('tr', null, ...columns.map((column) => h('th', { scope: 'col', class: style(column) }, column.head)));
  return {
    root: h('div', { class: 'table-frame', tabindex: 0, role: 'region', 'aria-label': caption }, h('table', null, h('caption', null, caption), h('thead', null, head), body)),
    body,
  };
}

export interface Tab {
  label: string;
  panel(): HTMLElement;
}

/** Tabs with arrow keys (WAI-ARIA practice); a panel is made when it is opened. */
export function tabs(label: string, list: readonly Tab[], first = 0): HTMLElement {
  const panel = h('div', { role: 'tabpanel', id: newId('panel'), tabindex: 0 });
  const heads = list.map((tab, k) =>
    h('button', { type: 'button', role: 'tab', id: newId('tab'), 'aria-controls': panel.id, onclick: () => open(k), onkeydown: (event: KeyboardEvent) => move(event, k) }, tab.label),
  );
  function open(k: number): void {
    heads.forEach((head, other) => {
      head.setAttribute('aria-selected', String(other === k));
      head.tabIndex = other === k ? 0 : -1;
    });
    panel.setAttribute('aria-labelledby', heads[k]?.id ?? '');
    const made = list[k]?.panel();
    panel.replaceChildren(...(made ? [made] : []));
  }
  function move(event: KeyboardEvent, from: number): void {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const to = (from + step + heads.length) % heads.length;
    open(to);
    heads[to]?.focus();
  }
  open(first);
  return h('div', { class: 'tabs' }, h('div', { role: 'tablist', 'aria-label': label }, ...heads), panel);
}
