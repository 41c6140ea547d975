// Colours for numbers: equal steps of the number look like equal steps of colour. The way through colour space is ours
// (a few stations of lightness, chroma and hue in Oklab); it is walked at constant speed in Oklab's distance.
// Oklab: B. Ottosson, "A perceptual color space for image processing", 2020.

export type Rgb = readonly [red: number, green: number, blue: number];
type Triple = readonly [number, number, number];

interface Station {
  lightness: number;
  chroma: number;
  /** Degrees. */
  hue: number;
}

// Dark violet through blue, teal and green to pale yellow: lightness rises all the way, so it also reads in grey.
const sequentialWay: Station[] = [
  { lightness: 0.23, chroma: 0.09, hue: 300 },
  { lightness: 0.42, chroma: 0.13, hue: 268 },
  { lightness: 0.6, chroma: 0.105, hue: 215 },
  { lightness: 0.78, chroma: 0.14, hue: 155 },
  { lightness: 0.95, chroma: 0.12, hue: 108 },
];

// Half a way each, from the middle outwards: shorter than expected is blue, longer is orange (told apart by all common
// forms of colour blindness). On dark ground the middle is dark, on light ground light, so that zero recedes.
const halves = {
  light: { middle: 0.95, end: 0.45, chroma: 0.1 },
  dark: { middle: 0.27, end: 0.8, chroma: 0.095 },
};
const lowHue = 255;
const highHue = 55;

function linearFromOklab([lightness, a, b]: Triple): Triple {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
}

function oklabFromLch(lightness: number, chroma: number, hue: number): Triple {
  const angle = (hue * Math.PI) / 180;
  return [lightness, chroma * Math.cos(angle), chroma * Math.sin(angle)];
}

function inGamut(linear: Triple): boolean {
  return linear.every((channel) => channel >= 0 && channel <= 1);
}

/** The nearest colour of the same lightness and hue that a screen has. */
function withinGamut(lab: Triple): Triple {
  if (inGamut(linearFromOklab(lab))) return lab;
  let low = 0;
  let high = 1;
  for (let step = 0; step < 24; ++step) {
    const middle = (low + high) / 2;
    if (inGamut(linearFromOklab([lab[0], lab[1] * middle, lab[2] * middle]))) low = middle;
    else high = middle;
  }
  return [lab[0], lab[1] * low, lab[2] * low];
}

function encoded(linear: number): number {
  const value = linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
  return Math.round(255 * Math.min(1, Math.max(0, value)));
}

/** Distance of two colours as Oklab sees it. */
export function oklabDistance(a: Triple, b: Triple): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/** `count` colours of a way at equal distances from each other. */
function walk(way: (share: number) => Triple, count: number): Triple[] {
  const fine = 4096;
  const places = Array.from({ length: fine + 1 }, (_, step) => withinGamut(way(step / fine)));
  const lengths = [0];
  for (let step = 1; step <= fine; ++step) lengths.push(lengths[step - 1]! + oklabDistance(places[step - 1]!, places[step]!));
  const whole = lengths[fine]!;
  const result: Triple[] = [];
  let at = 0;
  for (let n = 0; n < count; ++n) {
    const wanted = (whole * n) / (count - 1);
    while (at < fine - 1 && lengths[at + 1]! < wanted) ++at;
    const span = lengths[at + 1]! - lengths[at]!;
    const rest = span > 0 ? (wanted - lengths[at]!) / span : 0;
    const [from, to] = [places[at]!, places[at + 1]!];
    result.push([from[0] + rest * (to[0] - from[0]), from[1] + rest * (to[1] - from[1]), from[2] + rest * (to[2] - from[2])]);
  }
  return result;
}

/** A smooth way through stations (Catmull–Rom, so that no station shows as an edge). */
function throughStations(stations: Station[]): (share: number) => Triple {
  const points = stations.map((one) => oklabFromLch(one.lightness, one.chroma, one.hue));
  const at = (index: number): Triple => points[Math.min(points.length - 1, Math.max(0, index))]!;
  return (share) => {
    const place = share * (points.length - 1);
    const k = Math.min(points.length - 2, Math.floor(place));
    const t = place - k;
    const mix = (i: 0 | 1 | 2): number => {
      const [p, q, r, s] = [at(k - 1)[i], at(k)[i], at(k + 1)[i], at(k + 2)[i]];
      return 0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t * t + (3 * q - p - 3 * r + s) * t * t * t);
    };
    return [mix(0), mix(1), mix(2)];
  };
}

function half(ground: 'light' | 'dark', hue: number): (share: number) => Triple {
  const { middle, end, chroma } = halves[ground];
  return (share) => oklabFromLch(middle + (end - middle) * share, chroma * share, hue);
}

export const steps = 256;

/** The 256 Oklab colours of the map for values from little to much. */
export const sequentialLab: readonly Triple[] = walk(throughStations(sequentialWay), steps);

/** The same for values about zero, on a light or a dark page. */
export function divergingLab(ground: 'light' | 'dark'): readonly Triple[] {
  const low = walk(half(ground, lowHue), steps / 2);
  const high = walk(half(ground, highHue), steps / 2);
  return [...low.reverse(), ...high];
}

function rgbOf(lab: Triple): Rgb {
  const [red, green, blue] = linearFromOklab(lab);
  return [encoded(red), encoded(green), encoded(blue)];
}

export type ColourTable = readonly Rgb[];

export const sequential: ColourTable = sequentialLab.map(rgbOf);
export const diverging: Record<'light' | 'dark', ColourTable> = {
  light: divergingLab('light').map(rgbOf),
  dark: divergingLab('dark').map(rgbOf),
};

/** Where `value` lies between the ends, 0 … 1; what is beyond is at the end. */
export function shareOf(value: number, low: number, high: number): number {
  if (!(high > low)) return 0.5;
  return Math.min(1, Math.max(0, (value - low) / (high - low)));
}

export function colourOf(table: ColourTable, share: number): Rgb {
  return table[Math.min(table.length - 1, Math.max(0, Math.round(share * (table.length - 1))))]!;
}

export function cssColour([red, green, blue]: Rgb): string {
  return `rgb(${red} ${green} ${blue})`;
}
