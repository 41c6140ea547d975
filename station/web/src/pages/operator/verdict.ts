// Step 6: is the scan good? What to do if not; and the fit.
import { get } from '../../core/api';
import { h, replace } from '../../core/dom';
import { dateTime, fixed } from '../../core/format';
import type { Page } from '../../core/page';
import { navigate } from '../../core/router';
import { button, failurePanel, linkButton } from '../../core/ui';
import { noticeWords, tOperator as t } from '../../words/operator';
import { fitProgress } from './fit_progress';
import { profileName } from './names';
import type { Scan } from './records';
import { stepFrame, type StepFrame } from './step_frame';
import { takeUp, visit } from './visit';

const looks = { good: 'good', usable: 'warn', repeat: 'bad', '': 'warn' } as const;
const signs = { good: '✓', usable: '✓', repeat: '↻', '': '?' } as const;
const words = {
  good: ['verdict_good_title', 'verdict_good_text'],
  usable: ['verdict_usable_title', 'verdict_usable_text'],
  repeat: ['verdict_repeat_title', 'verdict_repeat_text'],
  '': ['verdict_none_title', 'verdict_none_text'],
} as const;

export const verdictPage: Page = {
  path: '/scans/:scan',
  roles: ['operator'],
  title: null,
  mount(root, parameters) {
    const scanId = parameters['scan'] ?? '';
    let end: () => void = () => {};
    let gone = false;
    const open = async () => {
      try {
        const scan = await get<Scan>(`/api/scans/${encodeURIComponent(scanId)}`);
        await takeUp(scan);
        if (gone) return;
        end();
        end = show(root, scan, () => void open());
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

function show(root: HTMLElement, scan: Scan, changed: () => void): () => void {
  const frame = stepFrame(root, { step: 'step_result', title: t('verdict_title'), back: null });
  const [title, text] = words[scan.verdict];
  const summary = scan.summary;
  const facts = summary
    ? h('p', { class: 'muted' }, [profileName(scan.profile), dateTime(scan.taken_ms), t('verdict_levels', { n: summary.levels, of: summary.planned_levels }), t('verdict_coverage', { n: fixed(100 * summary.coverage, 0) })].join(' · '))
    : null;
  const fit = scan.model ? null : fitProgress(scan.id, changed);
  replace(
    frame.content,
    h('section', { class: `verdict note ${looks[scan.verdict]}` }, h('span', { class: 'sign', 'aria-hidden': 'true' }, signs[scan.verdict]), h('div', null, h('h2', null, t(title)), h('p', null, t(text)), facts)),
    scan.recording_missing ? h('p', { class: 'note bad' }, t('verdict_missing')) : null,
    notices(scan),
    fit?.root ?? null,
  );
  drawActions(frame, scan);
  return () => {
    fit?.end();
    frame.end();
  };
}

function notices(scan: Scan): HTMLElement | null {
  const list = (scan.summary?.notices ?? []).map(noticeWords);
  if (list.length === 0) return null;
  return h('section', { class: 'stack' }, h('h2', null, t('verdict_notices')), h('ul', { class: 'lines' }, ...list.map((notice) => h('li', { class: 'card' }, h('p', null, notice.text), notice.advice ? h('p', null, h('strong', null, `${t('fault_do')}: `), notice.advice) : null))));
}

function drawActions(frame: StepFrame, scan: Scan): void {
  const repeat = button(t('verdict_again'), () => navigate('/visit/stand'), { kind: scan.verdict === 'repeat' ? 'primary' : 'plain', large: true, disabled: !visit.value.consent });
  const on = scan.model ? linkButton(t('verdict_on'), `/scans/${scan.id}/measurements`, { kind: scan.verdict === 'repeat' ? 'plain' : 'primary', large: true }) : null;
  replace(frame.actions, repeat, on);
}
