// Where a text stops being JSON: browsers do not always say.

const token = /\s*(?:([{}[\],:])|("(?:[^"\\\u0000-\u001f]|\\(?:["\\/bfnrt]|u[0-9a-fA-F]{4}))*")|(-?(?:0|[1-9]\d*)(?:\.\d+)?(?:[eE][+-]?\d+)?(?![\w.])|(?:true|false|null)\b))/y;

/** What may come: a value, a key, what follows a value … */
type Expected = 'value' | 'value or ]' | 'key' | 'key or }' | 'colon' | 'comma or end';

/** Position of the first character that cannot be, null if the text is JSON. */
export function jsonErrorAt(text: string): number | null {
  const open: string[] = [];
  let expected: Expected = 'value';
  token.lastIndex = 0;
  for (let at = 0; at < text.length; at = token.lastIndex) {
    const match = token.exec(text);
    const place = text.slice(at).search(/\S/);
    if (place < 0) break;
    if (!match) return at + place;
    const next: Expected | null = after(match, expected, open);
    if (next === null) return at + place;
    expected = next;
  }
  return open.length === 0 && expected === 'comma or end' ? null : text.length;
}

/** What may come behind a token, null if it may not stand here. */
function after([, sign, string]: RegExpExecArray, expected: Expected, open: string[]): Expected | null {
  const wantsValue = expected === 'value' || expected === 'value or ]';
  const wantsKey = expected === 'key' || expected === 'key or }';
  if (string !== undefined) return wantsKey ? 'colon' : wantsValue ? 'comma or end' : null;
  if (sign === undefined) return wantsValue ? 'comma or end' : null;
  if (sign === ':') return expected === 'colon' ? 'value' : null;
  if (sign === '{' || sign === '[') {
    if (!wantsValue) return null;
    open.push(sign);
    return sign === '{' ? 'key or }' : 'value or ]';
  }
  if (sign === ',') return expected !== 'comma or end' || open.length === 0 ? null : open.at(-1) === '{' ? 'key' : 'value';
  const opening = sign === '}' ? '{' : '[';
  const empty = sign === '}' ? 'key or }' : 'value or ]';
  if (open.at(-1) !== opening || (expected !== 'comma or end' && expected !== empty)) return null;
  open.pop();
  return 'comma or end';
}
