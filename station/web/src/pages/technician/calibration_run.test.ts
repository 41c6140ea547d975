import { describe, expect, it } from 'vitest';
import { allTaken, type CalibrationRun, type CalibrationStep, growth, underWay } from './calibration_run';

const step = (state: CalibrationStep['state'], residual: number | null = null, predicted: number | null = null): CalibrationStep => ({ what: '', picture: null, state, seconds: null, residual_mm: residual, predicted_common_mm: predicted });
const run = (steps: CalibrationStep[], state: CalibrationRun['state'] = 'place'): CalibrationRun => ({ id: '1', state, target: '', step: 0, steps, predicted_common_mm: 0.3, budget_mm: 0.2, message: '', error: null, result: null });

describe('a calibration under way', () => {
  it('is one that is not idle', () => {
    expect(underWay(null)).toBe(false);
    expect(underWay(run([], 'idle'))).toBe(false);
    expect(underWay(run([step('now')]))).toBe(true);
  });
  it('can be solved when every step has been taken', () => {
    expect(allTaken(run([step('taken'), step('again')]))).toBe(false);
    expect(allTaken(run([step('taken'), step('taken')]))).toBe(true);
    expect(allTaken(run([]))).toBe(false);
  });
});

it('its knowledge grows step by step, the limit beside it', () => {
  expect(growth(run([step('taken', 0.11), step('taken', 0.12), step('taken', 0.1, 0.4), step('taken', 0.13), step('now')]))).toEqual({
    steps: [1, 2, 3, 4, 5],
    residual: [0.11, 0.12, 0.1, 0.13, null],
    predicted: [null, null, 0.4, 0.3, null],
    budget: [0.2, 0.2, 0.2, 0.2, 0.2],
  });
});
