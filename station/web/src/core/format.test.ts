import { describe, expect, it } from 'vitest';
import { bytes, quantity } from './format';

describe('a quantity', () => {
  it('has no more digits than its interval allows', () => {
    expect(quantity(1234.56, 12.3, 'mm', 'mm')).toEqual({ value: '1,235', half: '12', unit: 'mm' });
    expect(quantity(923.45, 1.2, 'mm', 'mm')).toEqual({ value: '923.5', half: '1.2', unit: 'mm' });
  });
  it('is read in centimetres or inches where the person wants it', () => {
    expect(quantity(923.4, 4.2, 'mm', 'cm')).toEqual({ value: '92.34', half: '0.42', unit: 'cm' });
    expect(quantity(254, 25.4, 'mm', 'inch')).toEqual({ value: '10.0', half: '1.0', unit: 'in' });
  });
  it('of area is cm², of volume litres', () => {
    expect(quantity(123_400, 100, 'mm2', 'mm')).toEqual({ value: '1,234.0', half: '1.0', unit: 'cm²' });
    expect(quantity(4_567_000, 100_000, 'mm3', 'cm')).toEqual({ value: '4.57', half: '0.10', unit: 'L' });
  });
  it('without an interval has none', () => {
    expect(quantity(10, null, 'mm', 'mm').half).toBe('');
  });
});

describe('bytes', () => {
  it('are read in the unit that leaves few digits', () => {
    expect(bytes(999)).toBe('999 B');
    expect(bytes(12_345)).toBe('12.3 kB');
    expect(bytes(123_456_789)).toBe('123 MB');
  });
});
