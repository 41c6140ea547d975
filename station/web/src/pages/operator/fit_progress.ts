// The fit that follows every scan: how far it is, and what became of it.
import { get, post } from '../../core/api';
import { ApiFailure } from '../../core/api';
import { h, replace } from '../../core/dom';
import { on } from '../../core/live';
import { button, failurePanel, progress } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import type { Job } from '../../core/contract';

const kAskEvery_ms = 1500;

/** Follows the newest fit of a scan; `done` is called once when there is a model. */
export function fitProgress(scanId: string, done: () => void) {
  const bar = progress(t('fit_title'));
  const root = h('div', { class: 'card stack' }, bar.root);
  let ended = false;
  let job: Job | null = null;
  const show = (now: Job) => {
    if (ended || now.kind !== 'fit' || now.subject !== scanId) return;
    job = now;
    if (now.state === 'done') {
      finish();
      return done();
    }
    if (now.state === 'failed' || now.state === 'cancelled') {
      const text = now.error ?? { attempted: t('fit_title'), seen: t('fit_cancelled'), advice: t('fit_again') };
      replace(root, failurePanel(new ApiFailure(0, text)), h('div', { class: 'row' }, button(t('fit_again'), again, { kind: 'primary' })));
      return;
    }
    if (!root.contains(bar.root)) replace(root, bar.root);
    const left = now.eta_s === null || now.eta_s === undefined ? '' : t('fit_left', { n: Math.max(1, Math.ceil(now.eta_s)) });
    bar.set(now.state === 'waiting' ? null : now.share, now.state === 'waiting' ? t('fit_waiting') : left);
  };
  const again = async () => show(await post<Job>(`/api/scans/${encodeURIComponent(scanId)}/fit`));
  const ask = async () => {
    try {
      const { jobs } = await get<{ jobs: Job[] }>('/api/jobs');
      const mine = jobs.filter((one) => one.kind === 'fit' && one.subject === scanId);
      const newest = mine.find((one) => one.state === 'running' || one.state === 'waiting') ?? mine.at(-1);
      if (newest) show(newest);
      else if (!job && !ended) replace(root, h('p', null, t('fit_none')), h('div', { class: 'row' }, button(t('fit_start'), again, { kind: 'primary' })));
    } catch {
      // The frame says that the station does not answer; asked again below.
    }
  };
  const stopListening = on('job', (message) => show(message as unknown as Job));
  // The live line tells of every change; asking as well gets over one that broke.
  const timer = setInterval(() => void ask(), kAskEvery_ms);
  const finish = () => {
    ended = true;
    clearInterval(timer);
    stopListening();
  };
  void ask();
  return { root, end: finish };
}
