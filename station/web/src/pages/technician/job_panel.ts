// Work that takes a while (docs/console_api.md §6): follows a job and shows how far it is.
import { ApiFailure, get, post } from '../../core/api';
import type { Job } from '../../core/contract';
import { h, replace } from '../../core/dom';
import { on } from '../../core/live';
import { button, failurePanel, progress } from '../../core/ui';
import { ifEnglish } from '../../core/words';
import { t } from '../../words/technician';

const askEveryMs = 1000;

/** Follows a job by what the live line tells, and by asking in case it does not. `end` stops listening, not the job. */
export function followJob<Result>(first: Job<Result>, told: (job: Job<Result>) => void): { end(): void } {
  let over = false;
  const take = (job: Job<Result>) => {
    if (over || job.id !== first.id) return;
    if (job.state !== 'waiting' && job.state !== 'running') end();
    told(job);
  };
  const endLive = on('job', (message) => take((message['job'] ?? message) as unknown as Job<Result>));
  const timer = setInterval(() => void get<Job<Result>>(`/api/jobs/${first.id}`).then(take, () => {}), askEveryMs);
  function end(): void {
    over = true;
    clearInterval(timer);
    endLive();
  }
  take(first);
  return { end };
}

/** The last line of a cancelled job is an answer, too: nothing failed. */
export class JobCancelled extends Error {}

/**
 * A place on a page where jobs of one kind run, one after the other: progress with a button that cancels, and the
 * failure if there is one. `run` answers with the job's result.
 */
export function jobPanel(label: string) {
  const root = h('div', { class: 'job-panel', 'aria-live': 'polite' });
  let following: { end(): void } | null = null;

  async function run<Result>(start: () => Promise<Job<Result>>): Promise<Result> {
    following?.end();
    replace(root);
    const bar = progress(label);
    try {
      const job = await start();
      replace(root, bar.root, h('div', { class: 'row' }, button(t('cancel_job'), () => post(`/api/jobs/${job.id}/cancel`))));
      const last = await new Promise<Job<Result>>((resolve) => {
        following = followJob(job, (now) => {
          bar.set(now.state === 'waiting' ? null : now.share, lineOf(now));
          if (now.state !== 'waiting' && now.state !== 'running') resolve(now);
        });
      });
      replace(root);
      if (last.state === 'cancelled') throw new JobCancelled(t('job_cancelled'));
      if (last.state === 'failed') throw new ApiFailure(500, last.error ?? { attempted: label, seen: t('job_failed'), advice: '' });
      return last.result as Result;
    } catch (error) {
      replace(root, error instanceof JobCancelled ? h('p', { class: 'note' }, t('job_cancelled')) : failurePanel(error, undefined));
      throw error;
    }
  }
  return { root, run, dispose: () => following?.end() };
}

function lineOf(job: Job<unknown>): string {
  if (job.state === 'waiting') return t('job_waiting');
  const left = job.eta_s === null || job.eta_s === undefined ? '' : t('job_left', { n: Math.ceil(job.eta_s) });
  return [ifEnglish(job.stage), left].filter((part) => part !== '').join(' · ');
}
