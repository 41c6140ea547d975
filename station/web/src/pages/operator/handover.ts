// Step 8: what the customer takes along.
import { get, getBinary } from '../../core/api';
import { h, replace } from '../../core/dom';
import type { Units } from '../../core/format';
import type { Page } from '../../core/page';
import { session } from '../../core/session';
import { button, choice, failurePanel } from '../../core/ui';
import { language } from '../../core/words';
import { tOperator as t } from '../../words/operator';
import type { Scan } from './records';
import { stepFrame } from './step_frame';
import { endVisit, takeUp } from './visit';

const documents = [
  ['sheet', 'doc_sheet', 'doc_sheet_for', 'pdf'],
  ['csv', 'doc_csv', 'doc_csv_for', 'csv'],
  ['json', 'doc_json', 'doc_json_for', 'json'],
  ['smis', 'doc_smis', 'doc_smis_for', 'smis'],
  ['vit', 'doc_vit', 'doc_vit_for', 'vit'],
  ['freesewing', 'doc_freesewing', 'doc_freesewing_for', 'freesewing.json'],
  ['stl', 'doc_stl', 'doc_stl_for', 'stl'],
  ['model', 'doc_model', 'doc_model_for', 'json'],
] as const;
type Document = (typeof documents)[number];

/** Without one of these FreeSewing's file has no use, and the station does not make it. */
const ofTrunk = ['chest_girth', 'waist_girth', 'hip_girth'];

async function documentsOf(scanId: string): Promise<readonly Document[]> {
  const { measurements } = await get<{ measurements: { id: string }[] }>(`/api/scans/${encodeURIComponent(scanId)}/measurements`);
  return measurements.some((one) => ofTrunk.includes(one.id)) ? documents : documents.filter(([kind]) => kind !== 'freesewing');
}

export const handoverPage: Page = {
  path: '/scans/:scan/handover',
  roles: ['operator'],
  title: null,
  mount(root, parameters) {
    const scanId = parameters['scan'] ?? '';
    let end: () => void = () => {};
    let gone = false;
    const open = async () => {
      try {
        await takeUp(await get<Scan>(`/api/scans/${encodeURIComponent(scanId)}`));
        const offered = await documentsOf(scanId);
        if (!gone) end = show(root, scanId, offered);
      } catch (error) {
        if (!gone) replace(root, failurePanel(error, () => void open()));
      }
    };
    void open();
    return () => {
      gone = true;
      end();
    };
  },
};

function show(root: HTMLElement, scanId: string, offered: readonly Document[]): () => void {
  const frame = stepFrame(root, { step: 'step_hand_over', title: t('hand_title'), back: `/scans/${scanId}/measurements` });
  const words = choice(t('hand_language'), 'language', [['en', 'English'], ['ja', '日本語']], language.value);
  const units = choice(t('units'), 'units', [['mm', 'mm'], ['cm', 'cm'], ['inch', t('inch')]], session.value?.units ?? 'mm');
  const item = ([kind, name, use, ending]: Document) =>
    h(
      'li',
      { class: 'card line' },
      h('span', null, h('strong', null, t(name)), h('br'), h('span', { class: 'muted' }, t(use))),
      h('span', { class: 'row end' }, button(t('hand_save'), () => save(scanId, kind, ending, words.input.value, units.input.value as Units), { label: `${t('hand_save')}: ${t(name)}`, kind: kind === 'sheet' ? 'primary' : 'plain' })),
    );
  replace(frame.content, h('p', null, t('hand_text')), h('div', { class: 'columns' }, words.root, units.root), h('ul', { class: 'lines' }, ...offered.map(item)));
  replace(frame.actions, button(t('hand_end'), () => endVisit(), { kind: 'primary', large: true }));
  return frame.end;
}

/** Fetched first, so that a refusal is said here and not by a page of its own. */
async function save(scanId: string, kind: string, ending: string, words: string, units: Units): Promise<void> {
  const answer = await getBinary(`/api/scans/${encodeURIComponent(scanId)}/document?kind=${kind}&language=${words}&units=${units}`);
  const named = /filename="([^"]+)"/.exec(answer.headers.get('Content-Disposition') ?? '')?.[1];
  saveBlob(await answer.blob(), named ?? `${scanId}.${ending}`);
}

/** Hands bytes to the browser as a file. */
export function saveBlob(blob: Blob, name: string): void {
  const address = URL.createObjectURL(blob);
  const link = h('a', { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
