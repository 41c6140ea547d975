import { describe, expect, it } from 'vitest';
import { jsonErrorAt } from './json_error';

describe('the place of an error in a text', () => {
  const cases: [text: string, at: number][] = [
    ['{"a": [ oops ]}', 8],
    ['{"a": 1,}', 8],
    ['{"a" 1}', 5],
    ['[1 2]', 3],
    ['[1, 2', 5],
    ['{"a": 01}', 6],
    ['{a: 1}', 1],
    ['{"a": "x\n"}', 6],
    ['[1]]', 3],
    ['[1, ]', 4],
    ['', 0],
  ];
  it.each(cases)('of %j is at %i', (text, at) => {
    expect(jsonErrorAt(text)).toBe(at);
    expect(() => JSON.parse(text) as unknown).toThrow();
  });
  it.each(['{"a": [1, -2.5e3, true, null, "x\\n\\u00e4"], "b": {}, "c": []}\n', '7', ' [ ] '])('is nowhere in %j', (text) => {
    expect(jsonErrorAt(text)).toBeNull();
    expect(() => JSON.parse(text) as unknown).not.toThrow();
  });
});
