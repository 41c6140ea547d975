// Which page the address behind '#' stands for, and who may open it.
import type { Page, Role } from './page';

/** A page in the list: what the navigation needs at once, and the page itself, whose code is loaded when it is opened. */
export interface PageEntry extends Omit<Page, 'mount'> {
  load(): Promise<Pick<Page, 'mount'>>;
}

export interface Place {
  entry: PageEntry;
  parameters: Record<string, string>;
}

/** The parts of `path` that stand for ":name" in `pattern`, or null if it is another address. */
export function matchPath(pattern: string, path: string): Record<string, string> | null {
  const wanted = pattern.split('/');
  const parts = path.split('/');
  if (wanted.length !== parts.length) return null;
  const parameters: Record<string, string> = {};
  for (const [k, want] of wanted.entries()) {
    const part = decoded(parts[k] ?? '');
    if (part === null) return null;
    if (want.startsWith(':')) {
      if (part === '') return null;
      parameters[want.slice(1)] = part;
    } else if (want !== part) {
      return null;
    }
  }
  return parameters;
}

function decoded(part: string): string | null {
  try {
    return decodeURIComponent(part);
  } catch {
    return null; // A lone % sign: no page has such an address.
  }
}

/** The first entry whose pattern fits; patterns without ":name" go first, so that "/scans/new" is not a scan. */
export function findPage(entries: readonly PageEntry[], path: string): Place | null {
  const exact = entries.find((entry) => entry.path === path);
  if (exact) return { entry: exact, parameters: {} };
  for (const entry of entries) {
    const parameters = matchPath(entry.path, path);
    if (parameters) return { entry, parameters };
  }
  return null;
}

export function mayOpen(entry: PageEntry, role: Role): boolean {
  return entry.roles.includes(role);
}

/** Where a role begins: the first page of the navigation that it may open. */
export function firstPath(entries: readonly PageEntry[], role: Role): string | null {
  return entries.find((entry) => entry.title !== null && mayOpen(entry, role))?.path ?? null;
}

/** The path behind '#', "/" if there is none. */
export function pathOf(hash: string): string {
  const path = hash.replace(/^#/, '').split('?')[0] ?? '';
  return path === '' ? '/' : path;
}

/** Values put into a pattern: `pathTo('/scans/:scan', { scan: '7' })`. */
export function pathTo(pattern: string, parameters: Record<string, string> = {}): string {
  return pattern.replace(/:([a-z_]+)/g, (_, name: string) => encodeURIComponent(parameters[name] ?? ''));
}

export function navigate(path: string): void {
  location.hash = `#${path}`;
}
