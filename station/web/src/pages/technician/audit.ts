// Who did what: the chained log, filtered.
import { get } from '../../core/api';
import { h, replace } from '../../core/dom';
import { button, failurePanel, field, table } from '../../core/ui';
import { t } from '../../words/technician';
import { matching } from './audit_filter';
import type { AuditLine } from '../../core/contract';
import { badge, pageOf, timeText } from './page_parts';
import './technician.css';

interface AuditPart {
  lines: AuditLine[];
  verified: boolean;
  first_bad: number | null;
}

const atATime = 1000;

export const auditPage = {
  mount(root: HTMLElement): () => void {
    const verdict = h('div', { 'aria-live': 'polite' });
    const list = h('div', null);
    const search = field(t('audit_search'), 'search', { hint: t('audit_search_hint') });
    const more = button(t('older'), () => load(true));
    more.hidden = true;
    const lines: AuditLine[] = [];
    const draw = () => replace(list, drawn(matching(lines, search.value)));

    /** What is newest first; then, as far as there is more, the lines after it or (`older`) before it. */
    async function load(older = false): Promise<void> {
      try {
        const known = new Set(lines.map((line) => line.number));
        const take = async (from: number | null): Promise<AuditLine[]> => {
          const part = await get<AuditPart>(`/api/audit?limit=${atATime}${from === null ? '' : `&from=${from}`}`);
          replace(verdict, verdictOf(part));
          const fresh = part.lines.filter((line) => !known.has(line.number));
          for (const line of fresh) known.add(line.number);
          lines.push(...fresh);
          return part.lines.length < atATime ? [] : fresh;
        };
        let fresh = await take(older ? Math.max(1, Math.min(...known) - atATime) : null);
        while (!older && fresh.length > 0) fresh = await take(Math.max(...known) + 1);
        lines.sort((a, b) => b.number - a.number);
        more.hidden = (lines.at(-1)?.number ?? 1) <= 1;
        draw();
      } catch (error) {
        replace(verdict, failurePanel(error, () => void load(older)));
      }
    }
    search.input.addEventListener('input', draw);
    pageOf(root, t('audit_title'), h('p', null, t('audit_explain')), verdict, search.root, list, h('p', { class: 'row' }, more));
    void load();
    return () => {};
  },
};

function verdictOf(part: AuditPart): HTMLElement {
  if (part.verified) return h('p', { class: 'note good' }, `✓ ${t('chain_verified')}`);
  return h('p', { class: 'note bad' }, h('strong', null, `▲ ${t('chain_broken', { n: part.first_bad ?? '?' })}`), h('br'), t('chain_broken_do'));
}

function drawn(lines: readonly AuditLine[]): HTMLElement {
  const bad = (line: AuditLine) => line.action === 'refused' || /^(failed|refused|[45]\d\d)/.test(line.result);
  return table(
    t('audit_count', { n: lines.length }),
    [
      { head: '#', cell: (line: AuditLine) => line.number, number: true },
      { head: t('time'), cell: (line) => timeText(line.time_ms) },
      { head: t('user'), cell: (line) => line.user || t('nobody') },
      { head: t('origin'), cell: (line) => line.origin },
      { head: t('action'), cell: (line) => line.action },
      { head: t('subject'), cell: (line) => line.subject },
      { head: t('result'), cell: (line) => badge(bad(line) ? `▲ ${line.result}` : line.result, bad(line) ? 'bad' : '') },
      { head: t('hash'), cell: (line) => h('code', { title: line.hash }, line.hash.slice(0, 10)) },
    ],
    lines,
  ).root;
}
