// Words of the page in the person's language. Each area has a table with both languages side by side, so that one is
// never added without the other.
import { Signal } from './signal';

export type Language = 'en' | 'ja';
export type Words = Record<string, readonly [en: string, ja: string]>;

export const language = new Signal<Language>('en');

/** Makes the look-up of an area: `t('start')`, `t('left', { n: 3 })` puts 3 for {n}. */
export function wordsOf<T extends Words>(table: T): (key: keyof T & string, values?: Record<string, string | number>) => string {
  return (key, values) => {
    const pair = table[key];
    let text = pair ? pair[language.value === 'ja' ? 1 : 0] : key;
    for (const [name, value] of Object.entries(values ?? {})) text = text.replaceAll(`{${name}}`, String(value));
    return text;
  };
}

/** What the station has in English only (the stage of a job): nothing in another language. */
export function ifEnglish(text: string): string {
  return language.value === 'en' ? text : '';
}
