// STOP: always on the screen, with and without a session. It cancels whatever moves and is not the emergency stop.
import { post } from './api';
import { booth, moves } from './booth';
import { h, replace } from './dom';
import { language } from './words';
import { dialog, toast } from './overlay';
import { tShell } from '../words/shell';

/** Sends STOP, three times if need be; says so if the station cannot be reached. */
export async function stop(): Promise<void> {
  for (let attempt = 0; attempt < 3; attempt += 1) {
    try {
      await post('/api/stop');
      toast(tShell('stop_sent'), 'good');
      return;
    } catch {
      await new Promise((resolve) => setTimeout(resolve, 150));
    }
  }
  await dialog(tShell('stop'), [h('p', null, tShell('stop_failed'))], [{ answer: 'ok', text: tShell('close'), kind: 'primary' }]);
}

export function stopButton(): HTMLButtonElement {
  const element = h('button', { type: 'button', class: 'stop', 'aria-keyshortcuts': 'Escape Space', onclick: () => void stop() });
  language.watch(() => {
    element.title = tShell('stop_label');
    replace(element, h('strong', null, tShell('stop')), h('span', null, tShell('stop_not_emergency')));
  });
  return element;
}

/**
 * While the booth moves, Escape stops it wherever the focus is, and so does the space bar unless somebody writes.
 * While nothing moves both keys do what they do elsewhere.
 */
export function watchStopKeys(): void {
  addEventListener(
    'keydown',
    (event) => {
      const writes = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
      if (event.key !== 'Escape' && !(event.key === ' ' && !writes)) return;
      if (!moves(booth.value) || event.repeat) return;
      event.preventDefault();
      event.stopPropagation();
      void stop();
    },
    { capture: true },
  );
  // A button is pressed by the space bar when it comes up again.
  addEventListener('keyup', (event) => event.key === ' ' && moves(booth.value) && event.preventDefault(), { capture: true });
}
