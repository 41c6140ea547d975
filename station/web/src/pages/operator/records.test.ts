import { describe, expect, it } from 'vitest';
import { readMeasurements } from './measurement_lines';
import { standingConsent, type Consent } from './records';

const consent = (id: string, part: Partial<Consent> = {}): Consent => ({ id, purposes: ['measure'], text_version: '1', language: 'en', given_ms: 1, withdrawn_ms: null, ...part });

describe('the consent that stands', () => {
  it('is the newest one for the purpose that was not withdrawn', () => {
    const list = [consent('old'), consent('new', { given_ms: 5 }), consent('withdrawn', { given_ms: 9, withdrawn_ms: 10 }), consent('other', { given_ms: 8, purposes: ['glasses'] })];
    expect(standingConsent(list, 'measure')?.id).toBe('new');
    expect(standingConsent(list, 'glasses')?.id).toBe('other');
    expect(standingConsent(list, 'research')).toBeNull();
  });
});

describe('a line of the measurements', () => {
  it('has its unit from the name of its value, and its half width from the interval', () => {
    const [line] = readMeasurements({ measurements: [{ id: 'waist_girth', term: 'waist', value_mm: 800, low95_mm: 797, high95_mm: 803, measured_share: 0.9, curve: [[0, 0, 0], [1, 0, 0]] }] });
    expect(line).toMatchObject({ unit: 'mm', value: 800, half: 3, seen: 0.9, main: true });
    expect(line?.curve).toHaveLength(2);
  });
  it('without a value or an interval is left out, or has none', () => {
    const lines = readMeasurements({ measurements: [{ id: 'a', value_mm: null }, { id: 'b', value_deg: 3, high95_deg: null }] });
    expect(lines.map((line) => [line.id, line.unit, line.half, line.curve])).toEqual([['b', 'deg', null, null]]);
  });
});
