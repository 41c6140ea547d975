// Who is logged in, and until when (docs/console_api.md §2).
import { get, onAnswer, onSessionEnded, post, setCsrfToken } from './api';
import { connect, connected, on } from './live';
import type { Role } from './page';
import { Signal } from './signal';
import { language, type Language } from './words';

export interface Session {
  user: string | null;
  role: Role;
  csrf: string;
  /** On the booth's own screen. */
  local: boolean;
  setup_needed: boolean;
  station_id: string;
  version: string;
  simulated: boolean;
  language: Language;
  units: 'mm' | 'cm' | 'inch';
  /** Without use for so long, the session ends, s. */
  idle_s: number;
  store: { state: string; problem: string | null };
  booth_connected: boolean;
  certificate_problem: string | null;
}

/** Null until the station has answered for the first time. */
export const session = new Signal<Session | null>(null);
/** Why the last session ended by itself, "" if it did not. */
export const endedBecause = new Signal('');
/** Seconds until the session ends, when few are left; otherwise null. */
export const secondsLeft = new Signal<number | null>(null);

const kWarnBefore_s = 60;
let lastUse_ms = Date.now();
let lastTold_ms = Date.now();
let ticking: ReturnType<typeof setInterval> | undefined;

export function role(): Role {
  return session.value?.role ?? 'none';
}

/** Asks the station who we are; the live line is opened anew when that is somebody else. */
export async function loadSession(): Promise<void> {
  const before = session.value;
  const answer = await get<Session>('/api/session');
  take(answer);
  if (!before || before.user !== answer.user) connect();
}

export interface Credentials {
  user: string;
  password?: string;
  totp?: string;
  pin?: string;
}

/** @throws ApiFailure in the same words whatever was wrong (401), or "wait" (429). */
export async function login(credentials: Credentials): Promise<void> {
  endedBecause.set('');
  take(await post<Session>('/api/login', credentials));
  connect();
}

export async function logout(): Promise<void> {
  await post('/api/logout');
  await loadSession();
}

/** Makes the first account (only while there is none), and logs it in. */
export async function makeFirstAccount(user: string, password: string): Promise<void> {
  await post('/api/setup', { user, password });
  await loadSession();
  await login({ user, password });
}

/** Follows use of the page and news of the session. Called once. */
export function watchSession(): void {
  for (const event of ['pointerdown', 'keydown', 'wheel'] as const) {
    addEventListener(event, noteUse, { passive: true, capture: true });
  }
  ticking ??= setInterval(tick, 1000);
  onAnswer(() => {
    lastTold_ms = Date.now();
  });
  onSessionEnded(() => void ended('session'));
  let stood = false;
  connected.watch((yes) => {
    // The station may have been started anew meanwhile: who are we now?
    if (yes && stood) void loadSession().catch(() => {});
    stood ||= yes;
  });
  on('session_ended', (message) => void ended(String(message['reason'] ?? 'session')));
}

/** Tells the station that somebody is here: its count of idle time begins anew. */
export async function stayLoggedIn(): Promise<void> {
  noteUse();
  secondsLeft.set(null);
  take(await get<Session>('/api/session'));
}

function take(answer: Session): void {
  const before = session.value;
  setCsrfToken(answer.csrf);
  if (!before && !localStorage.getItem('annulus.language')) language.set(answer.language === 'ja' ? 'ja' : 'en');
  if (before?.user !== answer.user) secondsLeft.set(null);
  session.set(answer);
}

let ending = false;

async function ended(reason: string): Promise<void> {
  if (ending || role() === 'none') return;
  ending = true;
  try {
    await loadSession();
    if (role() === 'none') endedBecause.set(reason);
  } catch {
    // No line to the station: what was on the screen goes away all the same.
    if (session.value) session.set({ ...session.value, user: null, role: 'none' });
  } finally {
    ending = false;
  }
}

function noteUse(): void {
  lastUse_ms = Date.now();
}

/**
 * The station counts requests as use; reading and dragging make none, so it is told of them now and then. Without any
 * use there is a warning a minute before the end, and at the end we ask who we are.
 */
function tick(): void {
  const now = session.value;
  if (!now || now.role === 'none' || !(now.idle_s > 0)) return secondsLeft.set(null);
  const quiet_s = (Date.now() - Math.max(lastTold_ms, lastUse_ms)) / 1000;
  if (lastUse_ms > lastTold_ms && Date.now() - lastTold_ms > Math.min(60_000, now.idle_s * 250)) {
    void stayLoggedIn().catch(() => {});
    return;
  }
  const left = Math.ceil(now.idle_s - quiet_s);
  secondsLeft.set(left <= kWarnBefore_s ? Math.max(left, 0) : null);
  if (left <= 0) void ended('idle');
}
