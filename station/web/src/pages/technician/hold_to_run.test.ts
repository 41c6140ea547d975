import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { holdButton, HoldToRun } from './hold_to_run';

function rig() {
  const beats: string[] = [];
  const changes: (string | null)[] = [];
  const world = { allowed: true };
  const hold = new HoldToRun<string>({ beat: (direction) => beats.push(direction), allowed: () => world.allowed, changed: (direction) => changes.push(direction) });
  return { beats, changes, world, hold };
}

beforeEach(() => vi.useFakeTimers());
afterEach(() => vi.useRealTimers());

describe('hold to run', () => {
  it('beats at once and so often that two may be late before the booth’s 100 ms are over', () => {
    const { beats, hold } = rig();
    hold.press('up');
    expect(beats).toHaveLength(1);
    vi.advanceTimersByTime(100);
    expect(beats).toHaveLength(3);
    expect(new Set(beats)).toEqual(new Set(['up']));
  });
  it('sends nothing after the release', () => {
    const { beats, changes, hold } = rig();
    hold.press('down');
    vi.advanceTimersByTime(100);
    hold.release();
    vi.advanceTimersByTime(5000);
    expect(beats).toHaveLength(3);
    expect(changes).toEqual(['down', null]);
  });
  it('ends when the line is lost, and does not begin again by itself', () => {
    const { beats, hold, world } = rig();
    hold.press('up');
    world.allowed = false;
    vi.advanceTimersByTime(300);
    world.allowed = true;
    vi.advanceTimersByTime(5000);
    expect(beats).toHaveLength(1);
    expect(hold.direction).toBeNull();
  });
  it('does not begin while it is not allowed', () => {
    const { beats, hold, world } = rig();
    world.allowed = false;
    hold.press('up');
    vi.advanceTimersByTime(1000);
    expect(beats).toEqual([]);
  });
  it('ends when the other direction is pressed as well', () => {
    const { beats, hold } = rig();
    hold.press('up');
    hold.press('down');
    vi.advanceTimersByTime(1000);
    expect(beats).toEqual(['up']);
  });
});

class Pressed extends Event {
  constructor(
    type: string,
    readonly key = '',
    readonly repeat = false,
    readonly button = 0,
  ) {
    super(type, { cancelable: true });
  }
}

describe('the button', () => {
  function buttons() {
    const made = rig();
    const [button, window, document] = [new EventTarget(), new EventTarget(), new EventTarget()];
    const away = holdButton(button, 'up', ['Enter', 'ArrowUp'], made.hold, { window, document });
    return { ...made, button, window, document, away };
  }
  const endings: [name: string, from: 'button' | 'window' | 'document', event: string][] = [
    ['release', 'button', 'pointerup'],
    ['a pointer that leaves', 'button', 'pointerleave'],
    ['a touch that is taken away', 'button', 'pointercancel'],
    ['the button losing the focus', 'button', 'blur'],
    ['the window losing the focus', 'window', 'blur'],
    ['leaving the page', 'window', 'pagehide'],
    ['another tab', 'document', 'visibilitychange'],
  ];
  it.each(endings)('ends by %s', (_, from, event) => {
    const made = buttons();
    made.button.dispatchEvent(new Pressed('pointerdown'));
    vi.advanceTimersByTime(50);
    made[from].dispatchEvent(new Pressed(event));
    vi.advanceTimersByTime(1000);
    expect(made.beats).toHaveLength(2);
  });
  it('is held by a key until it comes up; repeats of the key count for nothing', () => {
    const made = buttons();
    made.button.dispatchEvent(new Pressed('keydown', 'Enter'));
    made.button.dispatchEvent(new Pressed('keydown', 'Enter', true));
    vi.advanceTimersByTime(100);
    made.button.dispatchEvent(new Pressed('keyup', 'Enter'));
    vi.advanceTimersByTime(1000);
    expect(made.beats).toHaveLength(3);
    made.button.dispatchEvent(new Pressed('keydown', 'Enter', true));
    expect(made.beats).toHaveLength(3);
  });
  it('knows nothing of other keys and buttons', () => {
    const made = buttons();
    made.button.dispatchEvent(new Pressed('keydown', ' '));
    made.button.dispatchEvent(new Pressed('pointerdown', '', false, 2));
    expect(made.beats).toEqual([]);
  });
  it('ends when the page is taken away, and listens no more', () => {
    const made = buttons();
    made.button.dispatchEvent(new Pressed('pointerdown'));
    made.away();
    made.button.dispatchEvent(new Pressed('pointerdown'));
    vi.advanceTimersByTime(1000);
    expect(made.beats).toHaveLength(1);
  });
});
