// What the server tells by itself, over one WebSocket (docs/console_api.md §5).
import { Signal } from './signal';

export type LiveMessage = { type: string } & Record<string, unknown>;

const listeners = new Map<string, Set<(message: LiveMessage) => void>>();
let socket: WebSocket | null = null;
let retry = 250;
let wanted = false;

/** Whether the line to the server stands. */
export const connected = new Signal(false);

/** Calls for every message of a type; what is returned ends it. */
export function on(type: string, listener: (message: LiveMessage) => void): () => void {
  const set = listeners.get(type) ?? new Set();
  listeners.set(type, set.add(listener));
  return () => set.delete(listener);
}

export function tell(message: LiveMessage): void {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

/** Opens the line, and opens it again whenever it breaks. Called again after a login: the session has changed. */
export function connect(): void {
  wanted = true;
  socket?.close();
  const mine = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/api/live`);
  socket = mine;
  mine.onopen = () => {
    retry = 250;
    connected.set(true);
  };
  mine.onmessage = (event) => {
    const message = JSON.parse(String(event.data)) as LiveMessage;
    for (const listener of listeners.get(message.type) ?? []) listener(message);
  };
  mine.onclose = () => {
    if (socket !== mine) return;
    connected.set(false);
    socket = null;
    if (wanted) setTimeout(connect, retry);
    retry = Math.min(retry * 2, 5000);
  };
}

export function disconnect(): void {
  wanted = false;
  socket?.close();
  socket = null;
}
