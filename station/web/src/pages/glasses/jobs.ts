// Long work of the server, followed to its end.
import { ApiFailure, get, post } from '../../core/api';
import type { Job as AnyJob } from '../../core/contract';
import { on } from '../../core/live';

export type Job = AnyJob<unknown>;

export function ended(job: Job): boolean {
  return job.state === 'done' || job.state === 'failed' || job.state === 'cancelled';
}

/** News come over the live line; asked for too, should that be down. */
const askEvery_ms = 1500;

/** Tells of a job from now until its end; what is returned stops the telling (not the job). */
export function followJob(first: Job, listener: (job: Job) => void): () => void {
  let over = false;
  let timer = 0;
  const tell = (job: Job): void => {
    if (over) return;
    if (ended(job)) stop();
    listener(job);
  };
  const ask = async (): Promise<void> => {
    try {
      tell(await get<Job>(`/api/jobs/${encodeURIComponent(first.id)}`));
    } catch {
      // The line is down: asked again below.
    }
    if (!over) timer = window.setTimeout(() => void ask(), askEvery_ms);
  };
  const off = on('job', (message) => {
    const job = (message['job'] ?? message) as unknown as Job;
    if (job.id === first.id) tell(job);
  });
  const stop = (): void => {
    over = true;
    window.clearTimeout(timer);
    off();
  };
  timer = window.setTimeout(() => void ask(), 300);
  listener(first);
  if (ended(first)) stop();
  return stop;
}

/** The result of a job that is done; throws its error if it failed, and null if it was cancelled. */
export function finished<Result>(first: Job, progress: (job: Job) => void = () => {}): Promise<Result | null> {
  return new Promise((resolve, reject) => {
    followJob(first, (job) => {
      progress(job);
      if (job.state === 'done') resolve(job.result as Result);
      if (job.state === 'cancelled') resolve(null);
      if (job.state === 'failed') reject(new JobFailed(job));
    });
  });
}

/** What a job that failed said. */
export class JobFailed extends ApiFailure {
  constructor(job: Job) {
    super(500, job.error ?? { attempted: job.stage, seen: 'it failed', advice: 'try again' });
  }
}

export function cancelJob(id: string): Promise<unknown> {
  return post(`/api/jobs/${encodeURIComponent(id)}/cancel`);
}
