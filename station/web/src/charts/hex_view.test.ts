import { describe, expect, it } from 'vitest';
import { bytesOfHex, hexLines } from './hex_view';

describe('bytes from text', () => {
  it('reads digits with and without spaces', () => {
    expect([...bytesOfHex('0aFF 10')!]).toEqual([10, 255, 16]);
    expect([...bytesOfHex('')!]).toEqual([]);
  });
  it('refuses half a byte and what is no digit', () => {
    expect(bytesOfHex('0af')).toBeNull();
    expect(bytesOfHex('zz')).toBeNull();
  });
});

// As `printf 'annulus\n\0ring of 180' | xxd -g1` shows them.
it('sixteen bytes stand in a line, in two groups, with their characters', () => {
  const bytes = new TextEncoder().encode('annulus\n\0ring of 180');
  expect(hexLines(bytes)).toEqual([
    { offset: '0000', hex: '61 6e 6e 75 6c 75 73 0a  00 72 69 6e 67 20 6f 66', text: 'annulus..ring of' },
    { offset: '0010', hex: '20 31 38 30'.padEnd(48), text: ' 180' },
  ]);
});
