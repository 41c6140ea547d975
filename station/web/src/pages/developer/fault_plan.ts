// Fault plans of a replay: templates, kinds, and what can be seen to be wrong before the station looks (docs/formats.md, "Fault plan").
import { jsonErrorAt } from './json_error';

export interface Fault {
  at: Record<string, number | string>;
  for_s?: number;
  target: string;
  kind: string;
  args?: Record<string, number | string>;
}

export interface FaultPlan {
  format: 'annulus fault plan';
  version: 1;
  seed?: number;
  faults: Fault[];
}

export interface FaultKind {
  target: 'usb' | 'can';
  kind: string;
  /** With the values that a new fault gets. */
  args: Record<string, number | string>;
  /** Happens once: takes no length. */
  once?: boolean;
}

/** What can go wrong in a replay: the faults of the ring's buses. The others are recorded already. */
export const replayKinds: readonly FaultKind[] = [
  { target: 'usb', kind: 'unplug', args: { board: 3, not_ready_s: 0 } },
  { target: 'usb', kind: 'short', args: { share: 0.01 } },
  { target: 'usb', kind: 'zero', args: { share: 0.01 } },
  { target: 'usb', kind: 'long', args: { share: 0.01 } },
  { target: 'usb', kind: 'damage', args: { share: 0.01 } },
  { target: 'usb', kind: 'timeout', args: { share: 0.01 } },
  { target: 'usb', kind: 'stall', args: { board: 3, share: 0.01 } },
  { target: 'usb', kind: 'no_memory', args: { board: 3, count: 1 } },
  { target: 'usb', kind: 'cancel_completes', args: { share: 1 } },
  { target: 'can', kind: 'lose', args: { share: 0.01 } },
  { target: 'can', kind: 'repeat', args: { share: 0.01 } },
  { target: 'can', kind: 'displace', args: { share: 0.01, frames: 4 } },
  { target: 'can', kind: 'overflow', args: { frames: 20 }, once: true },
  { target: 'can', kind: 'queue_full', args: {} },
  { target: 'can', kind: 'down', args: {} },
  { target: 'can', kind: 'gone', args: {} },
];

export function emptyPlan(): FaultPlan {
  return { format: 'annulus fault plan', version: 1, seed: 1, faults: [] };
}

/** A fault of a kind from a level on, for a while. */
export function faultOf(kind: FaultKind, level: number, forS: number): Fault {
  const fault: Fault = { at: { level }, target: kind.target, kind: kind.kind };
  if (!kind.once && forS > 0) fault.for_s = forS;
  if (Object.keys(kind.args).length > 0) fault.args = { ...kind.args };
  return fault;
}

export function planText(plan: FaultPlan): string {
  const faults = plan.faults.map((fault) => `    ${JSON.stringify(fault)}`).join(',\n');
  return `{\n  "format": "annulus fault plan", "version": 1, "seed": ${plan.seed ?? 1},\n  "faults": [${faults === '' ? '' : `\n${faults}\n  `}]\n}\n`;
}

export interface PlanProblem {
  text: string;
  /** 1 first; null: nowhere in particular. */
  line: number | null;
}

/** The plan in a text, or what is wrong with it as far as that shows here. */
export function readPlan(text: string): FaultPlan | PlanProblem {
  let json: unknown;
  try {
    json = JSON.parse(text);
  } catch (error) {
    return { text: error instanceof Error ? error.message : String(error), line: lineAt(text, jsonErrorAt(text)) };
  }
  const plan = json as Partial<FaultPlan> | null;
  if (plan === null || typeof plan !== 'object' || Array.isArray(plan)) return { text: 'a plan is an object', line: 1 };
  if (plan.format !== 'annulus fault plan') return { text: '"format" must be "annulus fault plan"', line: lineOf(text, '"format"') };
  if (plan.version !== 1) return { text: '"version" must be 1', line: lineOf(text, '"version"') };
  if (!Array.isArray(plan.faults)) return { text: '"faults" must be a list', line: lineOf(text, '"faults"') };
  const bad = plan.faults.findIndex((fault) => typeof fault !== 'object' || fault === null || !fault.at || !fault.target || !fault.kind);
  if (bad >= 0) return { text: `fault ${bad + 1} needs "at", "target" and "kind"`, line: null };
  return plan as FaultPlan;
}

export function isProblem(read: FaultPlan | PlanProblem): read is PlanProblem {
  return 'text' in read;
}

function lineOf(text: string, word: string): number | null {
  const at = text.indexOf(word);
  return lineAt(text, at < 0 ? null : at);
}

function lineAt(text: string, at: number | null): number | null {
  return at === null ? null : text.slice(0, at).split('\n').length;
}
