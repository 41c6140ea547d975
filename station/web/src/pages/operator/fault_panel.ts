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
    return panel(t('fault_away'), view.plain?.lost_text || view.why || t('fault_away_what'), t('fault_away_do'), t('who_operator'), null);
  }
  const [first, ...more] = view.status.causes;
  if (!first) return panel(t('fault_safe'), view.status.held_by, safeAdvice(view), t('who_operator'), null);
  const service = first.role === 'service';
  const acknowledge = service ? null : button(t('acknowledge'), () => post('/api/booth/acknowledge').then(refreshBooth), { kind: 'primary', large: true });
  const rest = more.map((cause) => h('li', null, `${cause.text}: ${cause.advice}`));
  return h(
    'div',
    null,
    panel(t('fault_title'), first.text, first.advice, service ? t('who_service') : t('who_operator'), acknowledge),
    rest.length > 0 ? h('details', null, h('summary', null, t('fault_more', { n: rest.length })), h('ul', null, ...rest)) : null,
  );
}

/** What the booth waits for, from the first of its plain steps that is not as it should be. */
function safeAdvice(view: BoothView): string {
  const step = view.plain?.steps.find((one) => !one.ok);
  return step?.advice || t('fault_safe_do');
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
