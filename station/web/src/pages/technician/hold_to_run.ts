// A movement that goes on only while somebody holds it: a beat at once and then often, none after the end. The station
// and boothd stop by themselves when beats stay out, whatever becomes of this page.

/** The booth waits 100 ms for the next one: two may be late. */
export const beatMs = 40;

export interface Holding<Direction> {
  /** Sends a beat. */
  beat(direction: Direction): void;
  /** Whether a hold may begin and go on: line, role, state. */
  allowed(): boolean;
  /** Told when a hold begins (its direction) and ends (null). */
  changed(direction: Direction | null): void;
}

export class HoldToRun<Direction> {
  #direction: Direction | null = null;
  #timer: ReturnType<typeof setInterval> | null = null;

  constructor(private readonly holding: Holding<Direction>) {}

  get direction(): Direction | null {
    return this.#direction;
  }

  /** Begins; one direction at a time: while one is held, another one ends it, and nothing moves until it is pressed anew. */
  press(direction: Direction): void {
    if (this.#direction !== null) {
      if (this.#direction !== direction) this.release();
      return;
    }
    if (!this.holding.allowed()) return;
    this.#direction = direction;
    this.holding.changed(direction);
    this.holding.beat(direction);
    this.#timer = setInterval(() => this.#tick(), beatMs);
  }

  release(): void {
    if (this.#timer !== null) clearInterval(this.#timer);
    this.#timer = null;
    if (this.#direction === null) return;
    this.#direction = null;
    this.holding.changed(null);
  }

  #tick(): void {
    if (this.#direction === null) return;
    if (!this.holding.allowed()) return this.release();
    this.holding.beat(this.#direction);
  }
}

type Target = Pick<EventTarget, 'addEventListener' | 'removeEventListener'>;

/**
 * A button that is held: by pointer or finger (which must stay on it) or by Enter or the direction's arrow key. The hold ends on release, when
 * the pointer leaves the button, and when button, window or page lose the attention. What is returned takes it away and ends a hold.
 */
export function holdButton<Direction>(button: Target, direction: Direction, keys: readonly string[], hold: HoldToRun<Direction>, page: { window: Target; document: Target } = { window, document }): () => void {
  const press = (event: Event) => {
    const pointer = event as PointerEvent;
    if (pointer.button !== 0) return;
    const element = event.target as Element | null;
    // A finger would keep hold of the button wherever it goes; leaving must end the hold.
    if (element?.hasPointerCapture?.(pointer.pointerId)) element.releasePointerCapture(pointer.pointerId);
    hold.press(direction);
  };
  const keyDown = (event: Event) => {
    const { key, repeat } = event as KeyboardEvent;
    if (!keys.includes(key)) return;
    event.preventDefault();
    if (!repeat) hold.press(direction);
  };
  const keyUp = (event: Event) => {
    if (keys.includes((event as KeyboardEvent).key)) hold.release();
  };
  const release = () => hold.release();
  const quiet = (event: Event) => event.preventDefault();
  const listeners: [Target, string, (event: Event) => void][] = [
    [button, 'pointerdown', press],
    [button, 'pointerup', release],
    [button, 'pointercancel', release],
    [button, 'pointerleave', release],
    [button, 'keydown', keyDown],
    [button, 'keyup', keyUp],
    [button, 'blur', release],
    [button, 'contextmenu', quiet],
    [page.window, 'blur', release],
    [page.window, 'pagehide', release],
    [page.document, 'visibilitychange', release],
  ];
  for (const [target, name, listener] of listeners) target.addEventListener(name, listener);
  return () => {
    hold.release();
    for (const [target, name, listener] of listeners) target.removeEventListener(name, listener);
  };
}
