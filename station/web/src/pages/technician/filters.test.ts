import { describe, expect, it } from 'vitest';
import { matching } from './audit_filter';
import { matchingKeys } from './parameter_filter';

describe('the audit', () => {
  const line = (number: number, user: string, action: string, result: string) => ({ number, time_ms: 0, user, origin: '127.0.0.1', action, subject: 'S-1', result, hash: '' });
  const lines = [line(1, 'operator', 'arm', 'ok'), line(2, '', 'login', 'refused'), line(3, 'operator', 'login', 'ok')];
  it('is narrowed down by every word', () => {
    expect(matching(lines, 'LOGIN').map((one) => one.number)).toEqual([2, 3]);
    expect(matching(lines, ' operator login ').map((one) => one.number)).toEqual([3]);
    expect(matching(lines, '')).toHaveLength(3);
  });
});

describe('the configuration', () => {
  const sections = [
    { name: 'ring', values: [{ key: 'radius_mm', value: 600, source: 'file', line: 3 }, { key: 'bus', value: 'usb', source: 'built in' }] },
    { name: 'sim', values: [{ key: 'seed', value: 7, source: 'built in' }] },
  ];
  it('is found by section, key and value', () => {
    expect(matchingKeys(sections, 'usb')).toEqual([{ name: 'ring', values: [sections[0]!.values[1]] }]);
    expect(matchingKeys(sections, '[sim]').map((one) => one.name)).toEqual(['sim']);
    expect(matchingKeys(sections, 'ring 600')[0]?.values).toHaveLength(1);
    expect(matchingKeys(sections, 'nothing')).toEqual([]);
  });
});
