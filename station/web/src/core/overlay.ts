// What lies above a page: dialogs and toasts. Dialogs leave the header free, so that STOP can be pressed at any time.
import { h, replace } from './dom';
import { tShell } from '../words/shell';

type Child = Node | string | null | false;

export interface DialogButton {
  /** What `dialog` answers. */
  answer: string;
  text: string;
  kind?: 'primary' | 'danger' | 'plain';
}

let open: { root: HTMLElement; close(answer: string | null): void } | null = null;

/** Asks; answers the button's `answer`, or null if it was closed (Escape, or another dialog). */
export function dialog(title: string, content: Child[], buttons: readonly DialogButton[]): Promise<string | null> {
  closeDialog();
  const before = document.activeElement as HTMLElement | null;
  return new Promise((resolve) => {
    const make = (one: DialogButton) =>
      h('button', { type: 'button', class: `button ${one.kind ?? 'plain'}`, onclick: () => mine.close(one.answer) }, one.text);
    const heading = h('h2', { id: 'dialog-title', tabindex: -1 }, title);
    const box = h(
      'div',
      { class: 'dialog stack', role: 'dialog', 'aria-modal': 'true', 'aria-labelledby': 'dialog-title', onkeydown: escape },
      heading,
      ...content,
      h('div', { class: 'row end' }, ...buttons.map(make)),
    );
    const mine = {
      root: h('div', { class: 'overlay' }, box),
      close(answer: string | null) {
        if (open === mine) open = null;
        mine.root.remove();
        setBehind(false);
        before?.focus();
        resolve(answer);
      },
    };
    function escape(event: KeyboardEvent): void {
      if (event.key === 'Escape') mine.close(null);
    }
    open = mine;
    document.body.append(mine.root);
    setBehind(true);
    (box.querySelector<HTMLElement>('input, select, textarea, .button.primary') ?? heading).focus();
  });
}

/** Closes what is open, as if Escape had been pressed. */
export function closeDialog(): void {
  open?.close(null);
}

/** Page and navigation cannot be reached while a dialog is open; the header, with STOP, can. */
function setBehind(inert: boolean): void {
  for (const part of document.querySelectorAll<HTMLElement>('main, .navigation')) part.inert = inert;
}

const toasts = h('div', { class: 'toasts', role: 'status', 'aria-live': 'polite' });

/** A line that goes by itself after 6 s; one of kind "bad" stays until it is closed or three newer ones have come. */
export function toast(text: string, kind: 'info' | 'good' | 'bad' = 'info'): void {
  if (text === '') return;
  if (!toasts.isConnected) document.body.append(toasts);
  const line = h('div', { class: `toast ${kind}` });
  replace(line, h('span', null, text), h('button', { type: 'button', class: 'button quiet', onclick: () => line.remove() }, tShell('close')));
  toasts.append(line);
  while (toasts.childElementCount > 3) toasts.firstElementChild?.remove();
  if (kind !== 'bad') setTimeout(() => line.remove(), 6000);
}

export function clearToasts(): void {
  toasts.replaceChildren();
}
