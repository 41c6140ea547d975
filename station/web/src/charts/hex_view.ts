// Bytes as text, sixteen a line: offset, hexadecimal, characters.

export interface HexLine {
  offset: string;
  /** Two groups of eight. */
  hex: string;
  text: string;
}

const perLine = 16;

/** Bytes of "0a ff" or "0aff"; null if that is no such text. */
export function bytesOfHex(text: string): Uint8Array | null {
  const digits = text.replace(/\s+/g, '');
  if (digits.length % 2 !== 0 || /[^0-9a-fA-F]/.test(digits)) return null;
  return Uint8Array.from({ length: digits.length / 2 }, (_, k) => parseInt(digits.slice(2 * k, 2 * k + 2), 16));
}

/** Lines of at most 16 bytes; what is no printable ASCII shows as a dot. The last line is padded to full width. */
export function hexLines(bytes: Uint8Array): HexLine[] {
  const lines: HexLine[] = [];
  for (let from = 0; from < bytes.length; from += perLine) {
    const part = [...bytes.subarray(from, from + perLine)];
    const cells = Array.from({ length: perLine }, (_, k) => part[k]?.toString(16).padStart(2, '0') ?? '  ');
    lines.push({
      offset: from.toString(16).padStart(4, '0'),
      hex: `${cells.slice(0, 8).join(' ')}  ${cells.slice(8).join(' ')}`,
      text: part.map((byte) => (byte >= 0x20 && byte < 0x7f ? String.fromCharCode(byte) : '.')).join(''),
    });
  }
  return lines;
}
