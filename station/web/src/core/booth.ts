// The booth as it was last told (docs/console_api.md §4, docs/wire_protocol.md §5.3).
import { get } from './api';
import type { Warning } from './booth_said';
import { connected, on } from './live';
import { role } from './session';
import { Signal } from './signal';
import { language } from './words';

export type BoothState = 'SAFE' | 'IDLE' | 'HOMING' | 'ARMED' | 'SCANNING' | 'STOPPING' | 'FAULT' | 'JOG';

export interface BoothCause {
  code: string;
  role: 'operator' | 'service';
  text: string;
  advice: string;
}

export interface BoothStatus {
  state: BoothState;
  version: number;
  homed: boolean;
  causes: BoothCause[];
  held_by: string;
  job: string;
  stage: string;
  done: number;
  total: number;
  start_presses: number;
  z_mm: number;
  warnings: Warning[];
  arm: { passed: boolean; checks: { name: string; error: { attempted: string; seen: string; advice: string } | null }[] } | null;
  scan: { number: number; complete: boolean; error: { attempted: string; seen: string; advice: string } | null } | null;
}

export interface PlainStep {
  id: string;
  ok: boolean;
  text: string;
  advice: string;
}

/** The booth in words of somebody in a shop. */
export interface PlainBooth {
  ready: boolean;
  steps: PlainStep[];
  causes: { code: string; service: boolean; text: string; advice: string; seen: string }[];
  state_text: string;
  lost_text: string;
}

export interface BoothView {
  connected: boolean;
  why: string;
  status: BoothStatus | null;
  plain: PlainBooth | null;
  booth?: { ring_radius_mm?: number; axis?: { z_min_mm: number; z_max_mm: number }; profiles?: string[]; simulated?: boolean } | null;
}

export const booth = new Signal<BoothView>({ connected: false, why: '', status: null, plain: null });

/** Whether something moves, or is about to. */
export function moves(view: BoothView): boolean {
  return ['HOMING', 'SCANNING', 'STOPPING', 'JOG', 'ARMED'].includes(view.status?.state ?? '');
}

/** Lamp colour as on the booth (docs/operator.md). */
export function lampOf(view: BoothView): 'green' | 'yellow' | 'red' | 'off' {
  if (!view.connected || !view.status) return 'off';
  const { state, causes } = view.status;
  if (state === 'FAULT' || (state === 'SAFE' && causes.length > 0)) return 'red';
  if (state === 'SAFE') return 'off';
  return state === 'IDLE' || state === 'ARMED' ? 'green' : 'yellow';
}

interface LiveStatus extends BoothView {
  plain_ja?: PlainBooth | null;
}

/** Follows the live line, which speaks both languages. Called once. */
export function watchBooth(): void {
  let newest: LiveStatus | null = null;
  const put = () => {
    if (!newest) return;
    const plain = language.value === 'ja' ? (newest.plain_ja ?? newest.plain) : newest.plain;
    booth.set({ connected: newest.connected, why: newest.why, status: newest.status, plain, booth: booth.value.booth ?? null });
  };
  on('status', (message) => {
    newest = message as unknown as LiveStatus;
    put();
  });
  connected.watch((yes) => {
    if (yes) void refreshBooth();
  });
  language.watch(() => {
    put();
    void refreshBooth();
  });
}

/** Asks now. Who is neither operator nor technician is told over the live line only. */
export async function refreshBooth(): Promise<void> {
  if (role() !== 'operator' && role() !== 'technician') return;
  try {
    booth.set(await get<BoothView>(`/api/booth?language=${language.value}`));
  } catch {
    // No line, or the session has ended: both are shown by the frame.
  }
}
