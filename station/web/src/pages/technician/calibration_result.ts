// The verdict of a calibration, with what stands on its certificate.
import { h } from '../../core/dom';
import { button, table } from '../../core/ui';
import { t } from '../../words/technician';
import type { CalibrationResult } from './calibration_run';
import { jsonView } from './json_view';
import { badge, quantity } from './page_parts';

interface Orders {
  accept(): Promise<void>;
  abandon(): Promise<void>;
}

type Limit = NonNullable<CalibrationResult['limits']>[number];

export function resultCard(result: CalibrationResult, orders: Orders): HTMLElement {
  const passed = result.passed ?? (result.verdict === 'pass' || result.verdict === 'passed');
  const { limits, findings, unobservable, budget, certificate, verdict, passed: _, ...rest } = result;
  return h(
    'section',
    { class: 'card stack calibration-result', 'aria-live': 'polite' },
    h('h2', null, t('result')),
    h('p', { class: passed ? 'note good' : 'note bad' }, h('strong', null, passed ? `✓ ${t('calibration_passed')}` : `▲ ${t('calibration_failed')}`)),
    limits && limits.length > 0 ? limitTable(limits) : null,
    ...(findings ?? []).map((one) => h('p', { class: 'note warn' }, h('strong', null, `▲ ${one.text}`), one.advice ? h('br') : null, one.advice)),
    budget && budget.length > 0 ? h('details', { open: true }, h('summary', null, t('error_budget')), jsonView(budget)) : null,
    unobservable && unobservable.length > 0 ? h('details', null, h('summary', null, t('cannot_be_known')), jsonView(unobservable)) : null,
    certificate ? certificateOf(certificate) : null,
    Object.keys(rest).length > 0 ? h('details', null, h('summary', null, t('all_values')), jsonView(rest)) : null,
    h('p', null, h('a', { class: 'button', href: '/api/calibration/report/run', target: '_blank', rel: 'noopener' }, t('report_pdf'))),
    h('div', { class: 'row' }, button(t('accept'), () => orders.accept(), { kind: 'primary', large: true, disabled: !passed }), button(t('abandon'), () => orders.abandon(), { kind: 'danger' })),
  );
}

function limitTable(limits: readonly Limit[]): HTMLElement {
  return table(
    t('limits'),
    [
      { head: t('what'), cell: (one: Limit) => one.what ?? one.name ?? '' },
      { head: t('as_found'), cell: (one) => quantity(one.as_found, 3, one.unit ?? 'mm'), number: true },
      { head: t('as_left'), cell: (one) => quantity(one.as_left, 3, one.unit ?? 'mm'), number: true },
      { head: t('limit'), cell: (one) => quantity(one.limit, 3, one.unit ?? 'mm'), number: true },
      { head: t('verdict'), cell: (one) => (one.passed ? badge(`✓ ${t('passed')}`, 'good') : badge(`▲ ${t('failed')}`, 'bad')) },
    ],
    limits,
  ).root;
}

function certificateOf(certificate: string | Record<string, unknown>): HTMLElement {
  if (typeof certificate === 'string') return h('p', null, h('strong', null, t('certificate')), ' ', h('code', null, certificate));
  return h('details', { open: true }, h('summary', null, t('certificate')), jsonView(certificate));
}
