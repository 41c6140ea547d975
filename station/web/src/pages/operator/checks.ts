// Step 3: what is to be measured, and is the booth ready?
import { post } from '../../core/api';
import { booth, refreshBooth, type BoothView } from '../../core/booth';
import { h, replace } from '../../core/dom';
import type { Page } from '../../core/page';
import { navigate } from '../../core/router';
import { button } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { customerProfiles, profileName, profileUse } from './names';
import { needs, stepFrame } from './step_frame';
import { changeVisit, visit } from './visit';

/** Seen to when the customer stands in the booth. */
const laterSteps = new Set(['stand', 'key']);

export const checksPage: Page = {
  path: '/visit/checks',
  roles: ['operator'],
  title: null,
  mount(root) {
    if (!needs('consent')) return () => {};
    const frame = stepFrame(root, { step: 'step_booth', title: t('checks_title'), back: '/visit/consent' });
    const profiles = h('div', { class: 'choices', role: 'radiogroup', 'aria-label': t('checks_profile') });
    const list = h('ul', { class: 'checks', 'aria-live': 'polite' });
    const home = button(t('checks_home'), () => post('/api/booth/home'), { kind: 'primary', large: true });
    const homeNote = h('p', { class: 'note warn' }, t('checks_home_text'));
    replace(frame.content, h('h2', null, t('checks_profile')), profiles, h('h2', null, t('checks_booth')), homeNote, list);
    const next = button(t('next'), () => navigate('/visit/stand'), { kind: 'primary', large: true });
    replace(frame.actions, home, next);
    void refreshBooth();
    let drawnProfiles = '';
    const end = booth.watch((view) => {
      const offered = offeredProfiles(view);
      if (drawnProfiles !== offered.join()) {
        drawnProfiles = offered.join();
        drawProfiles(profiles, offered);
      }
      drawChecks(list, view);
      const toHome = view.connected && view.status !== null && view.status.state === 'IDLE' && !view.status.homed;
      homeNote.hidden = home.hidden = !toHome;
      next.hidden = toHome;
      next.disabled = !canGoOn(view);
    });
    return () => {
      end();
      frame.end();
    };
  },
};

function offeredProfiles(view: BoothView): string[] {
  const known = view.booth?.profiles;
  return customerProfiles.filter((profile) => !known || known.includes(profile));
}

function canGoOn(view: BoothView): boolean {
  return view.connected && view.status?.state === 'IDLE' && view.status.homed;
}

function drawProfiles(root: HTMLElement, offered: readonly string[]): void {
  if (!offered.includes(visit.value.profile) && offered[0]) changeVisit({ profile: offered[0] });
  const choice = (profile: string) => {
    const input = h('input', { type: 'radio', name: 'profile', value: profile, checked: visit.value.profile === profile, onchange: () => changeVisit({ profile }) });
    return h('label', { class: 'card choice' }, input, h('span', null, h('strong', null, profileName(profile)), h('br'), h('span', { class: 'muted' }, profileUse(profile))));
  };
  replace(root, ...offered.map(choice));
}

function drawChecks(list: HTMLElement, view: BoothView): void {
  const steps = (view.plain?.steps ?? []).filter((step) => !laterSteps.has(step.id));
  const key = JSON.stringify(steps);
  if (list.dataset['key'] === key) return;
  list.dataset['key'] = key;
  const item = (step: (typeof steps)[number]) =>
    h(
      'li',
      { class: step.ok ? 'ok' : 'not' },
      h('span', { class: 'sign', 'aria-hidden': 'true' }, step.ok ? '✓' : '!'),
      h('span', null, h('span', { class: 'hidden-text' }, step.ok ? t('check_ok') : t('check_not')), h('strong', null, step.text), !step.ok && step.advice ? h('span', { class: 'advice' }, step.advice) : null),
    );
  replace(list, ...steps.map(item));
}
