// Language and colours of the page, kept in this browser.
import { Signal } from './signal';
import { language, type Language } from './words';

export type Theme = 'light' | 'dark';

/** Null: as the screen is set. */
export const theme = new Signal<Theme | null>(null);

export function restoreLook(): void {
  const kept = localStorage.getItem('annulus.theme');
  theme.set(kept === 'light' || kept === 'dark' ? kept : null);
  theme.watch((value) => {
    if (value) document.documentElement.dataset['theme'] = value;
    else delete document.documentElement.dataset['theme'];
  });
  const words = localStorage.getItem('annulus.language');
  if (words === 'en' || words === 'ja') language.set(words);
  language.watch((value) => {
    document.documentElement.lang = value;
  });
}

export function chooseLanguage(value: Language): void {
  localStorage.setItem('annulus.language', value);
  language.set(value);
}

export function shownTheme(): Theme {
  return theme.value ?? (matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light');
}

export function switchTheme(): void {
  const value = shownTheme() === 'dark' ? 'light' : 'dark';
  localStorage.setItem('annulus.theme', value);
  theme.set(value);
}
