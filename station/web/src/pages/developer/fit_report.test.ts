import { describe, expect, it } from 'vitest';
import { fitRows, optionsOf, pictureSource } from './fit_report';

describe('two fits beside each other', () => {
  const a = { model_id: 'a', rms_mm: 0.51, coefficients: 900, rejected: [1, 2, 3], time_s: { screening: 0.1, total: 1.5 } };
  const b = { model_id: 'b', rms_mm: 0.62, coefficients: 5760, time_s: { total: 0.4 } };
  it('have a row for every number that one of them has', () => {
    expect(fitRows(a, b)).toEqual([
      { key: 'rms_mm', a: 0.51, b: 0.62 },
      { key: 'coefficients', a: 900, b: 5760 },
      { key: 'rejected', a: 3, b: null },
      { key: 'time_s', name: 'screening, s', a: 0.1, b: null },
      { key: 'time_s', name: 'total, s', a: 1.5, b: 0.4 },
    ]);
  });
  it('may be one', () => expect(fitRows(null, b)[0]).toEqual({ key: 'rms_mm', a: null, b: 0.62 }));
});

describe('fit options', () => {
  it('have knots only for the uniform method', () => {
    expect(optionsOf('adaptive', '60', '80')).toEqual({ method: 'adaptive' });
    expect(optionsOf('uniform', '60', '')).toEqual({ method: 'uniform', theta_knots: 60 });
  });
});

it('a picture is an address', () => {
  expect(pictureSource({ model_id: 'a', residuals_png: 'iVBORw0' })).toBe('data:image/png;base64,iVBORw0');
  expect(pictureSource({ model_id: 'a' })).toBeNull();
});
