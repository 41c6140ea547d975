// The page's colours for what is drawn on canvases.
import { shownTheme, theme } from '../core/look';

export function cssValue(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export function ground(): 'light' | 'dark' {
  return shownTheme();
}

/** Calls at every change of the colours (not now); what is returned ends it. */
export function onTheme(listener: () => void): () => void {
  const screen = matchMedia('(prefers-color-scheme: dark)');
  screen.addEventListener('change', listener);
  let first = true;
  const end = theme.watch(() => {
    // The attribute of the root is set by another listener of the same signal, perhaps after this one.
    if (!first) queueMicrotask(listener);
    first = false;
  });
  return () => {
    screen.removeEventListener('change', listener);
    end();
  };
}

/** red, green, blue of "#rrggbb" or "rgb(r, g, b)". */
export function channels(css: string): [number, number, number] {
  if (css.startsWith('#') && css.length === 7) {
    return [1, 3, 5].map((k) => parseInt(css.slice(k, k + 2), 16)) as [number, number, number];
  }
  const numbers = css.match(/[\d.]+/g)?.map(Number) ?? [];
  return [numbers[0] ?? 128, numbers[1] ?? 128, numbers[2] ?? 128];
}
