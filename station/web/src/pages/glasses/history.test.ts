import { describe, expect, it } from 'vitest';
import { History } from './history';

function of(...values: number[]): History<number> {
  const history = new History({ value: 0, label: 'start' });
  for (const value of values) history.push(value, `to ${value}`);
  return history;
}

describe('history', () => {
  it('undoes and redoes step by step', () => {
    const history = of(1, 2);
    expect(history.undo()).toBe(true);
    expect(history.value).toBe(1);
    expect(history.undo()).toBe(true);
    expect(history.value).toBe(0);
    expect(history.undo()).toBe(false);
    history.redo();
    history.redo();
    expect(history.value).toBe(2);
    expect(history.redo()).toBe(false);
  });

  it('forgets what was undone once something else is done', () => {
    const history = of(1, 2);
    history.undo();
    history.push(3, 'to 3');
    expect(history.canRedo()).toBe(false);
    history.undo();
    expect(history.value).toBe(1);
  });

  it('takes a slider’s way as one step', () => {
    const history = of();
    for (const value of [1, 2, 3]) history.push(value, 'slider', 'height');
    history.settle();
    for (const value of [4, 5]) history.push(value, 'slider', 'height');
    expect(history.entries.map((entry) => entry.value)).toEqual([0, 3, 5]);
    history.undo();
    expect(history.value).toBe(3);
  });

  it('does not join ways of two sliders, nor one before and one after an undo', () => {
    const history = of();
    history.push(1, 'a', 'a');
    history.push(2, 'b', 'b');
    history.push(3, 'a', 'a');
    expect(history.entries).toHaveLength(4);
    history.undo();
    history.push(4, 'b', 'b');
    expect(history.value).toBe(4);
    history.undo();
    expect(history.value).toBe(2);
  });

  it('never changes the first entry, even by a keyed change', () => {
    const history = of();
    history.push(1, 'a', 'a');
    history.undo();
    history.push(2, 'a', 'a');
    history.undo();
    expect(history.value).toBe(0);
  });

  it('keeps the newest entries within its limit', () => {
    const history = new History({ value: 0, label: 'start' }, 3);
    for (const value of [1, 2, 3, 4]) history.push(value, '');
    expect(history.entries.map((entry) => entry.value)).toEqual([2, 3, 4]);
    history.undo();
    history.undo();
    expect(history.value).toBe(2);
    expect(history.canUndo()).toBe(false);
  });

  it('goes to any entry, and nowhere else', () => {
    const history = of(1, 2, 3);
    expect(history.go(1)).toBe(true);
    expect(history.value).toBe(1);
    expect(history.go(-1) || history.go(4) || history.go(0.5)).toBe(false);
    expect(history.value).toBe(1);
  });
});
