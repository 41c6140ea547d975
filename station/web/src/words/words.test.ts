import { describe, expect, it } from 'vitest';
import type { Words } from '../core/words';

// Every table of words, and every source that could use them.
const tables = import.meta.glob<Record<string, unknown>>('./*.ts', { eager: true });
const sources = import.meta.glob<string>('../**/*.ts', { eager: true, query: '?raw', import: 'default' });

const files = Object.entries(tables).filter(([file]) => !file.endsWith('.test.ts'));
const text = Object.entries(sources)
  .filter(([file]) => !file.startsWith('./') && !file.includes('/words/') && !file.endsWith('.test.ts'))
  .map(([, source]) => source)
  .join('\n');

/** Whatever could be a key. */
const named = new Set(text.match(/[A-Za-z0-9_.]+/g));
/** Of keys that are put together: `state_${state}`, `${method}_note`. */
const begins = [...text.matchAll(/`([a-z0-9]+_)\$\{/gi)].map((match) => match[1] ?? '');
const ends = [...text.matchAll(/\}(_[a-z0-9_]+)`/gi)].map((match) => match[1] ?? '');

function isTable(value: unknown): value is Words {
  return typeof value === 'object' && value !== null && Object.values(value).length > 0 && Object.values(value).every((pair) => Array.isArray(pair));
}

describe.each(files)('the words of %s', (_, module) => {
  const table = Object.values(module).find(isTable) ?? {};

  it('are there in both languages', () => {
    expect(Object.keys(table).length).toBeGreaterThan(0);
    const missing = Object.entries(table).filter(([, pair]) => pair.length !== 2 || pair.some((words) => words.trim() === ''));
    expect(missing).toEqual([]);
  });

  it('have the same places to fill in in both languages', () => {
    const holes = (words: string) => [...new Set(words.match(/\{[a-z_]+\}/g) ?? [])].sort().join();
    expect(Object.entries(table).filter(([, [en, ja]]) => holes(en) !== holes(ja))).toEqual([]);
  });

  it('are all used', () => {
    const unused = Object.keys(table).filter((key) => !named.has(key) && !begins.some((begin) => key.startsWith(begin)) && !ends.some((end) => key.endsWith(end)));
    expect(unused).toEqual([]);
  });
});
