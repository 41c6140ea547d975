// What is wrong with the booth: what happened, what to do, and who can do it.
import { post } from '../../core/api';
import { refreshBooth, type BoothView } from '../../core/booth';
import { h } from '../../core/dom';
import { button } from '../../core/ui';
import { tOperator as t } from '../../words/operator';

/** Whether the booth cannot work until somebody does something. */
export function isFault(view: BoothView): boolean {
  if (!view.connected || !view.status) return true;
  return view.status.state === 'FAULT' || view.status.state === 'SAFE';
}

export function faultPanel(view: BoothView): HTMLElement {
  if (!view.connected || !view.status) {
    return panel(t('fault_away'), t('fault_away_what'), view.plain?.lost_text || t('fault_away_do'), t('who_operator'), null);
  }
  const [first, ...more] = causesOf(view);
  if (!first) return panel(t('fault_safe'), notReady(view)?.text ?? view.status.held_by, notReady(view)?.advice || t('fault_safe_do'), t('who_operator'), null);
  const acknowledge = first.service ? null : button(t('acknowledge'), () => post('/api/booth/acknowledge').then(refreshBooth), { kind: 'primary', large: true });
  const rest = more.map((cause) => h('li', null, `${cause.text} ${cause.advice}`));
  return h(
    'div',
    null,
    panel(t('fault_title'), first.text, first.advice, first.service ? t('who_service') : t('who_operator'), acknowledge),
    rest.length > 0 ? h('details', null, h('summary', null, t('fault_more', { n: rest.length })), h('ul', null, ...rest)) : null,
  );
}

/** In plain words where the station has them, else in the booth's own. */
function causesOf(view: BoothView): { text: string; advice: string; service: boolean }[] {
  const plain = view.plain?.causes ?? [];
  if (plain.length > 0) return plain;
  return (view.status?.causes ?? []).map((cause) => ({ text: cause.text, advice: cause.advice, service: cause.role === 'service' }));
}

/** What the booth waits for: the first of its steps that is not as it should be. */
function notReady(view: BoothView) {
  return view.plain?.steps.find((step) => !step.ok);
}

function panel(title: string, what: string, advice: string, who: string, action: HTMLElement | null): HTMLElement {
  const line = (term: string, text: string, kind = '') => (text ? [h('dt', null, term), h('dd', { class: kind }, text)] : []);
  return h(
    'section',
    { class: 'failure stack', role: 'alert' },
    h('h2', null, title),
    h('dl', null, line(t('fault_what'), what), line(t('fault_do'), advice, 'do'), line(t('fault_who'), who)),
    action ? h('div', { class: 'row' }, action) : null,
  );
}
