// Recordings: what is there, what is in them, saving damaged ones.
import { get, post } from '../../core/api';
import { noticeWords, type Notice } from '../../core/booth_said';
import { h, replace } from '../../core/dom';
import { dialog } from '../../core/overlay';
import { button, linkButton, table } from '../../core/ui';
import { t } from '../../words/technician';
import { JobCancelled, jobPanel } from './job_panel';
import type { Job } from '../../core/contract';
import { jsonView } from './json_view';
import { badge, bytesText, card, Ends, loadInto, pageOf, terms, timeText } from './page_parts';
import './technician.css';

export interface RecordingRow {
  scan_id: string;
  profile: string;
  taken_ms: number;
  bytes: number | null;
  levels: number | null;
  verdict: string;
  state: string;
}

export const recordingsPage = {
  mount(root: HTMLElement): () => void {
    const ends = new Ends();
    const panel = jobPanel(t('recording_job'));
    ends.add(panel.dispose);
    const list = h('div', { class: 'middle' });
    const result = h('div', { class: 'stack', 'aria-live': 'polite', tabindex: -1 });
    const reload = () => loadInto(list, () => get<{ recordings: RecordingRow[] }>('/api/technician/recordings'), (answer) => replace(list, listed(answer.recordings, act)));
    async function act(row: RecordingRow, what: 'inspect' | 'recover'): Promise<void> {
      if (what === 'recover' && !(await confirmed(row))) return;
      try {
        const answer = await panel.run<object>(() => post<Job<object>>(`/api/technician/recordings/${encodeURIComponent(row.scan_id)}/${what}`));
        replace(result, what === 'inspect' ? inspected(row, answer) : recovered(row, answer));
        result.focus();
        if (what === 'recover') void reload();
      } catch (error) {
        if (!(error instanceof JobCancelled)) replace(result);
      }
    }
    pageOf(root, t('recordings_title'), h('p', null, t('recordings_explain')), panel.root, result, list);
    void reload();
    return () => ends.end();
  },
};

async function confirmed(row: RecordingRow): Promise<boolean> {
  const answer = await dialog(t('recover_title', { id: row.scan_id }), [h('p', null, t('recover_explain'))], [
    { answer: 'no', text: t('leave_it') },
    { answer: 'yes', text: t('recover'), kind: 'primary' },
  ]);
  return answer === 'yes';
}

function listed(rows: readonly RecordingRow[], act: (row: RecordingRow, what: 'inspect' | 'recover') => Promise<void>): HTMLElement {
  if (rows.length === 0) return h('p', { class: 'note' }, t('no_recordings'));
  return table(
    t('recordings_title'),
    [
      { head: t('scan'), cell: (row: RecordingRow) => row.scan_id },
      { head: t('profile'), cell: (row) => row.profile },
      { head: t('taken'), cell: (row) => timeText(row.taken_ms) },
      { head: t('levels'), cell: (row) => row.levels ?? '–', number: true },
      { head: t('size'), cell: (row) => (row.bytes === null ? '–' : bytesText(row.bytes)), number: true },
      { head: t('state'), cell: (row) => stateBadge(row.state) },
      {
        head: t('do'),
        cell: (row) =>
          h(
            'span',
            { class: 'row' },
            button(t('inspect'), () => act(row, 'inspect'), { label: `${t('inspect')} ${row.scan_id}` }),
            linkButton(t('replay'), `/developer/replay/${encodeURIComponent(row.scan_id)}`),
            button(t('recover'), () => act(row, 'recover'), { kind: 'quiet', label: `${t('recover')} ${row.scan_id}` }),
          ),
      },
    ],
    rows,
  ).root;
}

function stateBadge(state: string): HTMLElement {
  const known: Record<string, ['' | 'good' | 'warn' | 'bad', string]> = {
    kept: ['good', t('state_kept')],
    none: ['', t('state_none')],
    missing: ['bad', t('state_missing')],
  };
  const [kind, text] = known[state] ?? ['', state];
  return badge(text, kind);
}

function inspected(row: RecordingRow, report: object): HTMLElement {
  const { quality, ...rest } = report as { quality?: { verdict?: string; notices?: Notice[] } };
  const counts = { levels: row.levels ?? 0, planned_levels: null };
  const notices = (quality?.notices ?? []).map((one) => {
    const words = noticeWords(one, counts);
    return h('p', { class: 'note warn' }, h('strong', null, words.text), h('br'), words.advice);
  });
  return card(
    t('inspected', { id: row.scan_id }),
    ...notices,
    quality?.verdict ? terms([[t('verdict'), quality.verdict]]) : null,
    jsonView(rest),
    quality ? h('details', null, h('summary', null, t('quality')), jsonView(quality)) : null,
  );
}

function recovered(row: RecordingRow, report: object): HTMLElement {
  return card(t('recovered', { id: row.scan_id }), h('p', { class: 'note' }, t('recovered_explain')), jsonView(report));
}
