export type Role = 'none' | 'operator' | 'technician' | 'admin';

/** One page of the console. */
export interface Page {
  /** Pattern of the address behind '#': "/customers/:customer". */
  path: string;
  roles: Role[];
  /** For the navigation; null: not in it. */
  title: (() => string) | null;
  /** Puts the page into `root`; what is returned takes it away again (listeners, timers, GPU memory). */
  mount(root: HTMLElement, parameters: Record<string, string>): () => void;
}
