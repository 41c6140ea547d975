// Colours as the page keeps them. Hue, value and chroma are the server's business (POST /api/colour).

/** sRGB bytes, 0 … 255. */
export type Rgb = [red: number, green: number, blue: number];

/** A colour as it is chosen (paper 000, §6.1): where it was taken from, then darker ⇔ brighter and dull ⇔ vivid, −1 … 1. */
export interface ColourChoice {
  base: Rgb;
  brighter: number;
  vivid: number;
}

export function plainColour(base: Rgb): ColourChoice {
  return { base, brighter: 0, vivid: 0 };
}

/** "#rrggbb"; channels are rounded and held to 0 … 255. */
export function hexOf(rgb: Rgb): string {
  return `#${rgb.map((channel) => Math.max(0, Math.min(255, Math.round(channel))).toString(16).padStart(2, '0')).join('')}`;
}

/** The reverse, also of "#rgb"; null if it is no such text. */
export function rgbOfHex(text: string): Rgb | null {
  const short = /^#?([0-9a-f])([0-9a-f])([0-9a-f])$/i.exec(text.trim());
  const long = /^#?([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(text.trim());
  const parts = long?.slice(1) ?? short?.slice(1).map((digit) => digit + digit);
  return parts ? (parts.map((part) => parseInt(part, 16)) as Rgb) : null;
}

/** As LOOK.json has it: "#rrggbb,brighter:0.2,vivid:-0.3". */
export function lookColour(choice: ColourChoice): string {
  const change = (name: string, share: number): string => (share === 0 ? '' : `,${name}:${Number(share.toFixed(3))}`);
  return hexOf(choice.base) + change('brighter', choice.brighter) + change('vivid', choice.vivid);
}

/** The reverse for what this page writes; null for the other forms that LOOK.json may have. */
export function choiceOfLook(text: string): ColourChoice | null {
  const [head, ...changes] = text.split(',');
  const base = rgbOfHex(head ?? '');
  if (!base) return null;
  const choice = plainColour(base);
  for (const change of changes) {
    const match = /^(brighter|vivid):(-?\d+(?:\.\d+)?)$/.exec(change);
    if (!match || Math.abs(Number(match[2])) > 1) return null;
    choice[match[1] as 'brighter' | 'vivid'] = Number(match[2]);
  }
  return choice;
}

/** Linear light (0 … 1) of an sRGB byte (IEC 61966-2-1). */
export function linearOf(channel: number): number {
  const c = channel / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
}

/** WCAG's contrast between two colours, 1 … 21. */
export function contrast(a: Rgb, b: Rgb): number {
  const luminance = ([red, green, blue]: Rgb): number => 0.2126 * linearOf(red) + 0.7152 * linearOf(green) + 0.0722 * linearOf(blue);
  const [dark, light] = [luminance(a), luminance(b)].sort((x, y) => x - y) as [number, number];
  return (light + 0.05) / (dark + 0.05);
}

/** The most vivid colour of a hue in degrees (0 red, 120 green, 240 blue): what the bar shows until the server's is there. */
export function vividOfHue(hue_deg: number): Rgb {
  const channel = (offset: number): number => {
    const k = (offset + hue_deg / 60) % 6;
    return Math.round(255 * (1 - Math.max(0, Math.min(k, 4 - k, 1))));
  };
  return [channel(5), channel(3), channel(1)];
}

/** Hue in degrees of a colour as vividOfHue counts; 0 for greys. */
export function hueOf([red, green, blue]: Rgb): number {
  const most = Math.max(red, green, blue);
  const range = most - Math.min(red, green, blue);
  if (range === 0) return 0;
  const sixths = most === red ? ((green - blue) / range + 6) % 6 : most === green ? (blue - red) / range + 2 : (red - green) / range + 4;
  return 60 * sixths;
}
