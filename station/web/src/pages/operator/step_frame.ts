// The frame of a step: where we are, what is wrong with the booth, the step itself, and the ways on and back.
import { booth } from '../../core/booth';
import { h, replace } from '../../core/dom';
import { navigate } from '../../core/router';
import { button, linkButton } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { faultPanel, isFault } from './fault_panel';
import { endVisit, visit } from './visit';
import { dialog } from '../../core/overlay';

const steps = ['step_customer', 'step_consent', 'step_booth', 'step_stand', 'step_scan', 'step_result', 'step_measures', 'step_hand_over'] as const;
export type Step = (typeof steps)[number];

export interface StepLook {
  step: Step;
  title: string;
  /** A fault of the booth takes the place of the content (until acknowledged). */
  faultInstead?: boolean;
  back: string | null;
}

export interface StepFrame {
  /** Where the step puts its content. */
  content: HTMLElement;
  /** Beside the title: switches of the step. */
  tools: HTMLElement;
  /** Buttons on the right of the foot: the way on. */
  actions: HTMLElement;
  /** Ends what the frame watches. */
  end: () => void;
}

export function stepFrame(root: HTMLElement, look: StepLook): StepFrame {
  const fault = h('div', null);
  const content = h('div', { class: 'stack' });
  const actions = h('div', { class: 'row end' });
  const foot = h('div', { class: 'row' }, look.back ? linkButton(t('back'), look.back) : null, button(t('end_visit'), askEnd, { kind: 'quiet' }));
  const who = visit.value.customer?.name;
  const tools = h('div', { class: 'row' });
  replace(
    root,
    h(
      'div',
      { class: 'step' },
      stepList(look.step),
      h('div', { class: 'row spread' }, h('h1', null, look.title), h('div', { class: 'row' }, tools, who ? h('span', { class: 'badge' }, who) : null)),
      fault,
      content,
      h('div', { class: 'row spread step-foot' }, foot, actions),
    ),
  );
  const end = booth.watch((view) => {
    const faulty = isFault(view);
    const key = faulty ? JSON.stringify([view.connected, view.why, view.status?.causes, view.status?.held_by]) : '';
    if (fault.dataset['key'] !== key) {
      fault.dataset['key'] = key;
      replace(fault, faulty ? faultPanel(view) : null);
    }
    content.hidden = actions.hidden = faulty && look.faultInstead === true;
  });
  return { content, tools, actions, end };
}

function stepList(now: Step): HTMLElement {
  const at = steps.indexOf(now);
  const item = (step: Step, k: number) =>
    h('li', { class: k < at ? 'past' : k === at ? 'now' : '', 'aria-current': k === at ? 'step' : null }, h('span', { class: 'count', 'aria-hidden': 'true' }, k + 1), h('span', null, t(step)));
  return h('ol', { class: 'steps', 'aria-label': t('steps') }, ...steps.map(item));
}

/** Asks before a visit is ended whose scan has not been handed over. */
export async function askEnd(): Promise<void> {
  const answer = await dialog(t('end_title'), [h('p', null, t('end_text'))], [
    { answer: 'no', text: t('end_no') },
    { answer: 'yes', text: t('end_visit'), kind: 'primary' },
  ]);
  if (answer === 'yes') await endVisit();
}

/** Steps that need a customer, or a consent, send whoever has none to where it is asked for. False: sent away. */
export function needs(what: 'customer' | 'consent'): boolean {
  const { customer, consent } = visit.value;
  if (customer && (what === 'customer' || consent)) return true;
  navigate(customer ? '/visit/consent' : '/visit/customer');
  return false;
}
