// The record of actions, and whether it is whole.
import { get } from '../../core/api';
import type { AuditLine } from '../../core/contract';
import { h, replace } from '../../core/dom';
import { dateTime } from '../../core/format';
import type { Page } from '../../core/page';
import { role } from '../../core/session';
import { button, failurePanel, table, type Column } from '../../core/ui';
import { tAdmin as t } from '../../words/admin';

interface Audit {
  lines: AuditLine[];
  verified: boolean;
  first_bad: number | null;
}

const kPerPage = 50;

export const auditPage: Page = {
  path: '/admin/audit',
  roles: ['admin'],
  title: () => t('nav_audit'),
  mount(root) {
    const content = h('div', { class: 'stack' });
    const anchor = h('div', null);
    let gone = false;
    const load = async (from: number | null) => {
      try {
        const audit = await get<Audit>(`/api/audit?limit=${kPerPage}${from === null ? '' : `&from=${from}`}`);
        if (!gone) replace(content, ...auditParts(audit, from, load));
      } catch (error) {
        if (!gone) replace(content, failurePanel(error, () => void load(from)));
      }
    };
    void load(null);
    if (role() === 'admin') void showAnchor(anchor);
    replace(root, h('div', { class: 'stack' }, h('h1', null, t('audit_title')), h('p', null, t('audit_text')), content, anchor));
    return () => {
      gone = true;
    };
  },
};

function auditParts(audit: Audit, from: number | null, load: (from: number | null) => Promise<void>): HTMLElement[] {
  const state = audit.verified
    ? h('p', { class: 'note good' }, t('audit_whole'))
    : h('p', { class: 'note bad', role: 'alert' }, t('audit_broken', { n: audit.first_bad ?? '?' }));
  const columns: Column<AuditLine>[] = [
    { head: t('line'), cell: (line) => line.number, number: true },
    { head: t('time'), cell: (line) => dateTime(line.time_ms) },
    { head: t('user'), cell: (line) => line.user || '—' },
    { head: t('origin'), cell: (line) => line.origin },
    { head: t('action'), cell: (line) => line.action },
    { head: t('subject'), cell: (line) => line.subject },
    { head: t('result'), cell: (line) => line.result },
  ];
  const numbers = audit.lines.map((line) => line.number);
  const oldest = Math.min(...numbers);
  const newest = Math.max(...numbers);
  const older = button(t('older'), () => load(Math.max(1, oldest - kPerPage)), { disabled: numbers.length === 0 || oldest <= 1 });
  const newer = button(t('newer'), () => load(newest + 1), { disabled: from === null || numbers.length < kPerPage });
  return [state, h('div', { class: 'row' }, older, newer), table(t('audit_title'), columns, [...audit.lines].sort((a, b) => b.number - a.number)).root];
}

async function showAnchor(root: HTMLElement): Promise<void> {
  try {
    const { date, number, hash } = await get<{ date: string; number: number; hash: string }>('/api/audit/anchor');
    replace(root, h('section', { class: 'card' }, h('h2', null, t('anchor')), h('p', null, t('anchor_text')), h('p', null, h('code', { class: 'secret' }, `${date} · ${number} · ${hash}`))));
  } catch (error) {
    replace(root, failurePanel(error));
  }
}
