// What the station tells of an opened recording (docs/console_api.md §12).
import type { Range } from '../../charts/scale';

export interface ReplayEvent {
  time_ns: number;
  kind: string;
  text: string;
}

export interface SafetyChange {
  time_ns: number;
  line: string;
  level: boolean | number;
}

export interface OpenReplay {
  replay_id: string;
  levels: number;
  sweeps: number;
  from_ns: number;
  to_ns: number;
  has_raw_bytes?: boolean;
  sensors: number;
  radius_mm: number;
  events: ReplayEvent[];
  safety: SafetyChange[];
}

export interface Frame {
  time_ns: number;
  bus: string;
  direction: string;
  bytes_hex: string;
  meaning: string;
}

export interface ReplayLevel {
  n: number;
  sweep: number;
  level: number;
  time_ns: number;
  z_mm: number;
  range_mm: (number | null)[];
  stamps: unknown;
  frames: Frame[];
}

/** As `annulus replay --json`. */
export interface ReplayOutcome {
  identical: boolean;
  whole: boolean;
  recorded_levels: number;
  replayed_levels: number;
  identical_levels: number;
  axis_points: number;
  differing: number;
  worst_range_mm: number;
  worst_z_mm: number;
  unknown_records: number;
  first_difference: { level?: number; sweep?: number; index?: number; sensor?: number; field: string; recorded: string; replayed: string } | null;
  faults: string[];
  faults_passed_over: string[];
  scan_s: number;
  replay_s: number;
}

/** What there is to see: from the first event to the last, but not more than some seconds beyond the levels. */
export function wholeTime(replay: OpenReplay, lastLevelS: number): Range {
  const beyondS = 4;
  const times = [...replay.events, ...replay.safety].map((one) => secondsOf(replay, one.time_ns)).filter((one) => one > -beyondS && one < lastLevelS + beyondS);
  const least = lastLevelS > 0 ? lastLevelS : 1;
  return { low: Math.min(0, ...times), high: Math.max(least, ...times) };
}

export function secondsOf(replay: OpenReplay, timeNs: number): number {
  return (timeNs - replay.from_ns) / 1e9;
}
