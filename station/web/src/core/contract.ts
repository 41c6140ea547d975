// Shapes of docs/console_api.md that pages of several areas read.
import type { ErrorText } from './api';

/** §6: work in a process of its own. */
export interface Job<Result = Record<string, unknown>> {
  id: string;
  kind: string;
  subject: string;
  state: 'waiting' | 'running' | 'done' | 'failed' | 'cancelled';
  stage: string;
  /** 0 … 1. */
  share: number;
  eta_s: number | null;
  error: ErrorText | null;
  result: Result | null;
}

/** §13: one line of the audit. */
export interface AuditLine {
  number: number;
  time_ms: number;
  user: string;
  origin: string;
  action: string;
  subject: string;
  result: string;
  hash: string;
}
