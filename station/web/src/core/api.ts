// Requests to the server (docs/console_api.md).

export interface ErrorText {
  attempted: string;
  seen: string;
  advice: string;
}

/** A request that was refused, or did not arrive (status 0). */
export class ApiFailure extends Error {
  constructor(
    readonly status: number,
    readonly text: ErrorText,
    readonly field: string | null = null,
  ) {
    super(`${text.attempted}: ${text.seen}: ${text.advice}`);
  }
}

let csrfToken = '';
let sessionEnded: () => void = () => {};
let answered: () => void = () => {};

/** The token that every POST carries; from GET /api/session. */
export function setCsrfToken(token: string): void {
  csrfToken = token;
}

/** Told when an answer says that nobody is logged in. */
export function onSessionEnded(listener: () => void): void {
  sessionEnded = listener;
}

/** Told of every answer: the station counts requests as use of the session. */
export function onAnswer(listener: () => void): void {
  answered = listener;
}

export async function get<T>(path: string): Promise<T> {
  return (await send('GET', path, null, 'application/json')).json() as Promise<T>;
}

export async function getBinary(path: string): Promise<Response> {
  return send('GET', path, null, 'application/json');
}

export async function post<T>(path: string, body: object = {}): Promise<T> {
  return (await send('POST', path, JSON.stringify(body), 'application/json')).json() as Promise<T>;
}

/** A POST whose answer is bytes (a mesh). `signal` gives it up when a newer one is on its way. */
export async function postForBinary(path: string, body: object, signal?: AbortSignal): Promise<Response> {
  return send('POST', path, JSON.stringify(body), 'application/json', signal);
}

export async function postFile<T>(path: string, file: Blob): Promise<T> {
  return (await send('POST', path, file, 'application/octet-stream')).json() as Promise<T>;
}

async function send(
  method: string,
  path: string,
  body: BodyInit | null,
  type: string,
  signal?: AbortSignal,
): Promise<Response> {
  const headers: Record<string, string> = {};
  if (method === 'POST') {
    headers['Content-Type'] = type;
    headers['X-CSRF-Token'] = csrfToken;
  }
  let response: Response;
  try {
    response = await fetch(path, { method, headers, body, credentials: 'same-origin', cache: 'no-store', signal: signal ?? null });
  } catch (error) {
    if (error instanceof DOMException && error.name === 'AbortError') throw error;
    throw new ApiFailure(0, { attempted: 'ask the station', seen: 'no answer', advice: 'wait: the page tries again; the booth goes on by itself' });
  }
  answered();
  if (response.ok) return response;
  const answer = (await response.json().catch(() => null)) as { error?: ErrorText; field?: string } | null;
  if (response.status === 401 && path !== '/api/login') sessionEnded();
  throw new ApiFailure(
    response.status,
    answer?.error ?? { attempted: 'ask the station', seen: `answer ${response.status}`, advice: 'try again; if it stays, call the service' },
    answer?.field ?? null,
  );
}
