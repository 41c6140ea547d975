// How long data of customers are kept.
import { get, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { date } from '../../core/format';
import { dialog, toast } from '../../core/overlay';
import type { Page } from '../../core/page';
import { button, failurePanel, field, runBusy, showAtField, showFailure, table } from '../../core/ui';
import { tAdmin as t } from '../../words/admin';

interface Retention {
  days: number;
  expired: { id: string; keep_until_ms: number }[];
}

interface Proof {
  customer_id: string;
  marker_hits: number;
}

const kMostDays = 3650;

export const retentionPage: Page = {
  path: '/admin/retention',
  roles: ['admin'],
  title: () => t('nav_retention'),
  mount(root) {
    const content = h('div', { class: 'stack' });
    let gone = false;
    const load = async () => {
      try {
        const retention = await get<Retention>('/api/retention');
        if (!gone) replace(content, daysForm(retention, () => void load()), expired(retention, () => void load()));
      } catch (error) {
        if (!gone) replace(content, failurePanel(error, () => void load()));
      }
    };
    void load();
    replace(root, h('div', { class: 'stack' }, h('h1', null, t('retention_title')), h('p', null, t('retention_text')), content));
    return () => {
      gone = true;
    };
  },
};

function daysForm(retention: Retention, again: () => void): HTMLElement {
  const days = field(t('days'), 'days', { type: 'number', min: 1, max: kMostDays, step: 1, value: String(retention.days) });
  const save = h('button', { type: 'submit', class: 'button primary' }, t('save'));
  const send = async () => {
    const count = Number(days.value);
    if (!Number.isInteger(count) || count < 1 || count > kMostDays) return days.error(t('days_bad'));
    try {
      await post('/api/retention', { days: count });
      toast(t('saved'), 'good');
      again();
    } catch (error) {
      if (!showAtField(error, [days])) showFailure(error);
    }
  };
  return h('form', { class: 'card stack', novalidate: true, onsubmit: (event: Event) => (event.preventDefault(), void runBusy(save, send)) }, days.root, h('div', { class: 'row end' }, save));
}

function expired(retention: Retention, again: () => void): HTMLElement {
  if (retention.expired.length === 0) return h('p', { class: 'note good' }, t('apply_none'));
  const count = retention.expired.length;
  const apply = async () => {
    const answer = await dialog(t('apply_title'), [h('p', null, t('apply_text', { n: count }))], [
      { answer: 'no', text: t('cancel'), kind: 'primary' },
      { answer: 'yes', text: t('apply'), kind: 'danger' },
    ]);
    if (answer !== 'yes') return;
    const { erased } = await post<{ erased: Proof[] }>('/api/retention/apply');
    const hits = erased.reduce((sum, proof) => sum + proof.marker_hits, 0);
    toast(t('applied', { n: erased.length, hits }), hits === 0 ? 'good' : 'bad');
    again();
  };
  const columns = [
    { head: t('subject'), cell: (one: Retention['expired'][number]) => one.id },
    { head: t('until'), cell: (one: Retention['expired'][number]) => date(one.keep_until_ms) },
  ];
  return h('div', { class: 'stack' }, table(t('expired'), columns, retention.expired).root, h('div', null, button(t('apply'), apply, { kind: 'danger' })));
}
