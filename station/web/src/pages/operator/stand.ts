// Step 4: stand so, and let the sway of stepping on die down.
import { h, replace } from '../../core/dom';
import type { Page } from '../../core/page';
import { button, failurePanel } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { countdown } from './countdown';
import { prepareGrowth } from './growth';
import { armScan } from './order_scan';
import { say, silence, tone } from './prompts';
import { soundSwitch } from './sound_switch';
import { standDrawing } from './stand_drawing';
import { needs, stepFrame } from './step_frame';
import { visit } from './visit';

/** After that the sway of somebody who has stepped on has died down (docs/operator.md, "swayed"). */
const kSettle_s = 20;
const kLastTicks = 3;

export const standPage: Page = {
  path: '/visit/stand',
  roles: ['operator'],
  title: null,
  mount(root) {
    if (!needs('consent')) return () => {};
    const frame = stepFrame(root, { step: 'step_stand', title: t('stand_title'), faultInstead: true, back: '/visit/checks' });
    const rules = [t('stand_rule_clothes'), t('stand_rule_feet'), t('stand_rule_arms'), t('stand_rule_look'), t('stand_rule_breath')];
    if (visit.value.profile === 'head') rules.unshift(t('stand_rule_head'));
    const settle = h('div', { class: 'settle stack' });
    const sound = soundSwitch();
    replace(frame.tools, sound.root);
    replace(
      frame.content,
      h('div', { class: 'columns' }, h('div', { class: 'card' }, standDrawing()), h('div', { class: 'stack' }, h('ol', { class: 'rules' }, ...rules.map((rule) => h('li', null, rule))), settle)),
    );
    const arm = async () => {
      try {
        await armScan();
      } catch (error) {
        replace(settle, failurePanel(error));
        replace(frame.actions, button(t('scan_arm'), arm, { kind: 'primary', large: true }));
      }
    };
    let timer: { end: () => void } = { end: () => {} };
    const wait = () => {
      tone('tick');
      say(t('say_still'));
      const ring = countdown(t('stand_settle'), kSettle_s, (left) => left <= kLastTicks && tone('tick'), () => {
        tone('ready');
        replace(settle, h('p', null, t('scan_checking')));
        void arm();
      });
      timer = ring;
      replace(settle, h('p', { class: 'lead' }, t('stand_settle')), ring.root);
      replace(frame.actions, button(t('stand_again'), again), button(t('stand_skip'), () => (ring.end(), arm())));
    };
    const again = () => {
      timer.end();
      replace(settle);
      replace(frame.actions, button(t('stand_wait'), wait, { kind: 'primary', large: true }));
    };
    again();
    void prepareGrowth();
    return () => {
      timer.end();
      silence();
      sound.end();
      frame.end();
    };
  },
};
