// Which recording is to be replayed.
import { get } from '../../core/api';
import { h, replace } from '../../core/dom';
import { linkButton, table } from '../../core/ui';
import { t } from '../../words/developer';
import { bytesText, loadInto, timeText } from '../technician/page_parts';
import type { RecordingRow } from '../technician/recordings';
import '../technician/technician.css';

export const choosePage = {
  mount(root: HTMLElement): () => void {
    const list = h('div', null);
    replace(root, h('h1', null, t('choose_title')), h('p', null, t('choose_explain')), list);
    void loadInto(list, () => get<{ recordings: RecordingRow[] }>('/api/technician/recordings'), (answer) => replace(list, listed(answer.recordings)));
    return () => {};
  },
};

function listed(rows: readonly RecordingRow[]): HTMLElement {
  const kept = rows.filter((row) => row.state === 'kept');
  if (kept.length === 0) return h('p', { class: 'note' }, t('nothing_to_replay'));
  return table(
    t('recordings'),
    [
      { head: t('scan'), cell: (row: RecordingRow) => row.scan_id },
      { head: t('profile'), cell: (row) => row.profile },
      { head: t('taken'), cell: (row) => timeText(row.taken_ms) },
      { head: t('levels'), cell: (row) => row.levels ?? '–', number: true },
      { head: t('size'), cell: (row) => (row.bytes === null ? '–' : bytesText(row.bytes)), number: true },
      { head: '', cell: (row) => linkButton(t('open'), `/developer/replay/${encodeURIComponent(row.scan_id)}`, { kind: 'primary' }) },
    ],
    kept,
  ).root;
}
