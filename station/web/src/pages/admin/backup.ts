// Backups.
import { ApiFailure, get, post, type ErrorText } from '../../core/api';
import { h, replace } from '../../core/dom';
import { bytes } from '../../core/format';
import { on } from '../../core/live';
import type { Page } from '../../core/page';
import { button, failurePanel, progress } from '../../core/ui';
import { ifEnglish } from '../../core/words';
import { tAdmin as t } from '../../words/admin';

interface BackupJob {
  id: string;
  kind: string;
  state: 'waiting' | 'running' | 'done' | 'failed' | 'cancelled';
  stage: string;
  share: number;
  error: ErrorText | null;
  result: { backup: string; keys: string; bytes: number } | null;
}

const kAskEvery_ms = 1000;

export const backupPage: Page = {
  path: '/admin/backup',
  roles: ['admin'],
  title: () => t('nav_backup'),
  mount(root) {
    const state = h('div', null);
    const bar = progress(t('backup_title'));
    let running: BackupJob | null = null;
    const show = (job: BackupJob) => {
      running = job.state === 'waiting' || job.state === 'running' ? job : null;
      make.disabled = running !== null;
      if (running) {
        bar.set(job.share, ifEnglish(job.stage));
        replace(state, bar.root);
      } else if (job.result && job.state === 'done') {
        replace(state, h('p', { class: 'note good' }, t('backup_done', { backup: job.result.backup, keys: job.result.keys, bytes: bytes(job.result.bytes) })));
      } else {
        replace(state, failurePanel(new ApiFailure(0, job.error ?? { attempted: t('backup_title'), seen: t('backup_failed'), advice: '' })));
      }
    };
    const make = button(t('backup_button'), async () => {
      const job = await post<BackupJob>('/api/backup');
      // After the button is free again, or it would be set so.
      queueMicrotask(() => show(job));
    }, { kind: 'primary', large: true });
    const stopListening = on('job', (message) => {
      const job = message as unknown as BackupJob;
      if (job.kind === 'backup') show(job);
    });
    const timer = setInterval(() => {
      if (running) void get<BackupJob>(`/api/jobs/${running.id}`).then(show, () => {});
    }, kAskEvery_ms);
    replace(root, h('div', { class: 'stack' }, h('h1', null, t('backup_title')), h('p', null, t('backup_text')), h('div', null, make), state));
    return () => {
      stopListening();
      clearInterval(timer);
    };
  },
};
