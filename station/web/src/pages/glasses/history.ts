// Undo and redo of values.

export interface HistoryEntry<T> {
  value: T;
  /** What led to it, for people. */
  label: string;
}

/**
 * What a value was, step by step. Changes with the same key that follow each other are one step until settle(): a slider
 * that is drawn along is undone as a whole.
 */
export class History<T> {
  #entries: HistoryEntry<T>[];
  #at = 0;
  #openKey: string | null = null;

  /** Keeps at most `limit` (≥ 2) entries; the oldest go first. */
  constructor(
    first: HistoryEntry<T>,
    private readonly limit = 200,
  ) {
    this.#entries = [first];
  }

  get value(): T {
    return this.#entries[this.#at]!.value;
  }

  get position(): number {
    return this.#at;
  }

  get entries(): readonly HistoryEntry<T>[] {
    return this.#entries;
  }

  /** Takes a new value; what had been undone is gone. `key`: changes that belong together, null: a step of its own. */
  push(value: T, label: string, key: string | null = null): void {
    const same = key !== null && key === this.#openKey && this.#at > 0;
    this.#entries.length = this.#at + 1;
    if (same) this.#entries[this.#at] = { value, label };
    else {
      this.#entries.push({ value, label });
      if (this.#entries.length > this.limit) this.#entries.shift();
      this.#at = this.#entries.length - 1;
    }
    this.#openKey = key;
  }

  /** Ends a step: the next change is another one, whatever its key. */
  settle(): void {
    this.#openKey = null;
  }

  canUndo(): boolean {
    return this.#at > 0;
  }

  canRedo(): boolean {
    return this.#at + 1 < this.#entries.length;
  }

  /** False if there is nothing to undo. */
  undo(): boolean {
    return this.go(this.#at - 1);
  }

  redo(): boolean {
    return this.go(this.#at + 1);
  }

  /** Goes to an entry; false if there is none of that number. */
  go(position: number): boolean {
    if (!Number.isInteger(position) || position < 0 || position >= this.#entries.length) return false;
    this.#at = position;
    this.#openKey = null;
    return true;
  }
}
