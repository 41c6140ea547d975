// What the station tells of a guided calibration (docs/console_api.md §11).
import type { FoundPlace } from './target_picture';
import type { TargetPlace } from './target_place';

export interface CalibrationStep {
  what: string;
  picture: TargetPlace | null;
  state: 'open' | 'now' | 'taken' | 'again' | 'failed';
  seconds: number | null;
  residual_mm: number | null;
  predicted_common_mm?: number | null;
  problems?: string[];
  found?: FoundPlace | null;
}

export interface CalibrationRun {
  id: string;
  state: 'idle' | 'place' | 'scanning' | 'solving' | 'done' | 'failed';
  target: string;
  step: number;
  steps: CalibrationStep[];
  predicted_common_mm: number | null;
  budget_mm: number | null;
  message: string;
  error: { attempted: string; seen: string; advice: string } | null;
  result: CalibrationResult | null;
}

export interface CalibrationResult {
  verdict?: string;
  passed?: boolean;
  name?: string;
  limits?: { what?: string; name?: string; as_found?: number | null; as_left?: number | null; limit?: number | null; unit?: string; passed?: boolean }[];
  findings?: { code?: string; text: string; advice?: string }[];
  unobservable?: (string | { text: string })[];
  budget?: { what?: string; name?: string; girth_mm?: number; volume_share?: number }[];
  certificate?: string | Record<string, unknown>;
}

export interface PastCalibration {
  name: string;
  made_ms: number;
  verdict: string;
  sigma_common_mm: number | null;
}

export interface Calibration {
  current: PastCalibration | null;
  history: PastCalibration[];
  run: CalibrationRun | null;
  targets: (string | { spec: string; name: string })[];
}

/** A run that somebody has to go on with. */
export function underWay(run: CalibrationRun | null): run is CalibrationRun {
  return run !== null && run.state !== 'idle';
}

/** Whether every step has been taken (what is only failed can be taken again). */
export function allTaken(run: CalibrationRun): boolean {
  return run.steps.length > 0 && run.steps.every((step) => step.state === 'taken');
}

/** Step (1 first), residual, predicted knowledge and limit, for the plots. */
export function growth(run: CalibrationRun): { steps: number[]; residual: (number | null)[]; predicted: (number | null)[]; budget: (number | null)[] } {
  const newest = run.steps.reduce((last, step, k) => (step.state === 'taken' ? k : last), -1);
  return {
    steps: run.steps.map((_, k) => k + 1),
    residual: run.steps.map((step) => step.residual_mm ?? null),
    predicted: run.steps.map((step, k) => step.predicted_common_mm ?? (k === newest ? run.predicted_common_mm : null)),
    budget: run.steps.map(() => run.budget_mm),
  };
}
