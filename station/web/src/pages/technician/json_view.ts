// Any JSON as terms and values, nested ones to be opened.
import { h } from '../../core/dom';

const fewNumbers = 8;

export function jsonView(value: unknown): HTMLElement {
  if (Array.isArray(value)) return list(value);
  if (value !== null && typeof value === 'object') return object(value as Record<string, unknown>);
  return h('span', { class: typeof value === 'number' ? 'number' : '' }, plain(value));
}

function plain(value: unknown): string {
  if (value === null || value === undefined) return '–';
  if (typeof value === 'boolean') return value ? 'true' : 'false';
  if (typeof value === 'number') return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(6)));
  return String(value);
}

function isPlain(value: unknown): boolean {
  return value === null || typeof value !== 'object';
}

function object(value: Record<string, unknown>): HTMLElement {
  return h('dl', { class: 'terms json' }, Object.entries(value).flatMap(([key, one]) => [h('dt', null, key), h('dd', null, folded(one))]));
}

function list(value: unknown[]): HTMLElement {
  if (value.every(isPlain)) return h('span', { class: 'number' }, value.map(plain).join(', ') || '–');
  return h('ol', { class: 'json' }, value.map((one) => h('li', null, jsonView(one))));
}

/** What is long is closed at first. */
function folded(value: unknown): Node {
  const long = Array.isArray(value) ? value.length > fewNumbers || !value.every(isPlain) : !isPlain(value);
  if (!long) return jsonView(value);
  const count = Array.isArray(value) ? value.length : Object.keys(value as object).length;
  const details = h('details', null, h('summary', null, Array.isArray(value) ? `[${count}]` : `{${count}}`));
  details.addEventListener('toggle', () => details.childElementCount === 1 && details.append(jsonView(value)), { once: true });
  return details;
}
