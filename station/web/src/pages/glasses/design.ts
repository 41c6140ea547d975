// What a designer decides, and how it is written for the server (docs/console_api.md §9, LOOK.json).
import { choiceOfLook, lookColour, plainColour, type ColourChoice } from './colour';
import type { Prescription } from './prescription';

export const materials = ['plastic', 'translucent', 'metal', 'brushed'] as const;
export const patterns = ['plain', 'tortoiseshell', 'horn', 'pearl', 'carved'] as const;
export const coatings = ['none', 'anti_reflective', 'mirror'] as const;

export type Material = (typeof materials)[number];
export type Pattern = (typeof patterns)[number];
export type Coating = (typeof coatings)[number];
export type Half = 'upper' | 'lower';

export interface HalfLook {
  colour: ColourChoice;
  material: Material;
  pattern: Pattern;
  /** Size of the pattern, 0.1 … 10. */
  scale: number;
}

export interface LensLook {
  tint: ColourChoice;
  /** Share of the light that goes through, 0 … 1; `lower` differs for a gradient. */
  transmittance: number;
  lower: number | null;
  coating: Coating;
  /** Shown where there is no prescription, −30 … 30 D. */
  power_d: number;
}

export interface FrameLook {
  upper: HalfLook;
  /** Null: as the upper half. */
  lower: HalfLook | null;
  lens: LensLook;
}

/** One design, as the server takes it, and its look. */
export interface Design {
  style: string;
  /** Name of a size of the style; empty: the style's shape as it is. */
  size: string;
  /** What differs from the style: option → number in the field's unit, or a word. */
  fields: Record<string, number | string>;
  look: FrameLook;
}

/** Everything that undo gives back. */
export interface Bench {
  a: Design;
  /** Null: one design only. */
  b: Design | null;
  active: 'a' | 'b';
  prescription: Prescription | null;
}

export function firstLook(): FrameLook {
  return {
    upper: { colour: plainColour([60, 42, 30]), material: 'plastic', pattern: 'plain', scale: 1 },
    lower: null,
    lens: { tint: plainColour([255, 255, 255]), transmittance: 0.92, lower: null, coating: 'anti_reflective', power_d: 0 },
  };
}

export function activeDesign(bench: Bench): Design {
  return bench.active === 'b' && bench.b ? bench.b : bench.a;
}

/** The bench with its active design changed. */
export function withDesign(bench: Bench, change: (design: Design) => Design): Bench {
  return bench.active === 'b' && bench.b ? { ...bench, b: change(bench.b) } : { ...bench, a: change(bench.a) };
}

/** The look of a half: the lower one is the upper's unless it is its own. */
export function halfOf(look: FrameLook, half: Half): HalfLook {
  return half === 'lower' ? (look.lower ?? look.upper) : look.upper;
}

export function withHalf(design: Design, half: Half, change: Partial<HalfLook>): Design {
  return { ...design, look: { ...design.look, [half]: { ...halfOf(design.look, half), ...change } } };
}

export function withLens(design: Design, change: Partial<LensLook>): Design {
  return { ...design, look: { ...design.look, lens: { ...design.look.lens, ...change } } };
}

/** `design` of a request. */
export function designBody(design: Design): object {
  return { style: design.style, ...(design.size && { size: design.size }), fields: design.fields };
}

/** LOOK.json. */
export function lookBody(look: FrameLook): object {
  const half = (one: HalfLook): object => ({
    colour: lookColour(one.colour),
    material: one.material,
    texture: { pattern: one.pattern, scale: one.scale },
  });
  return {
    format: 'annulus-look',
    version: 1,
    upper: half(look.upper),
    ...(look.lower && { lower: half(look.lower) }),
    lens: {
      tint: lookColour(look.lens.tint),
      transmittance: look.lens.transmittance,
      ...(look.lens.lower !== null && { lower_transmittance: look.lens.lower }),
      coating: look.lens.coating,
      power_d: look.lens.power_d,
    },
  };
}

interface LookFile {
  upper?: HalfFile;
  lower?: HalfFile;
  lens?: { tint?: string; transmittance?: number; lower_transmittance?: number; coating?: string; power_d?: number };
}
interface HalfFile {
  colour?: string;
  material?: string;
  texture?: { pattern?: string; scale?: number };
}

/** A look out of LOOK.json; what is missing or written in a way that the page does not write is as in firstLook(). */
export function lookOfFile(file: LookFile): FrameLook {
  const fresh = firstLook();
  const half = (one: HalfFile): HalfLook => ({
    colour: choiceOfLook(one.colour ?? '') ?? fresh.upper.colour,
    material: oneOf(materials, one.material, fresh.upper.material),
    pattern: oneOf(patterns, one.texture?.pattern, fresh.upper.pattern),
    scale: one.texture?.scale ?? fresh.upper.scale,
  });
  const lens = file.lens ?? {};
  return {
    upper: half(file.upper ?? {}),
    lower: file.lower ? half(file.lower) : null,
    lens: {
      tint: choiceOfLook(lens.tint ?? '') ?? fresh.lens.tint,
      transmittance: lens.transmittance ?? fresh.lens.transmittance,
      lower: lens.lower_transmittance ?? null,
      coating: oneOf(coatings, lens.coating, fresh.lens.coating),
      power_d: lens.power_d ?? fresh.lens.power_d,
    },
  };
}

function oneOf<T extends string>(known: readonly T[], text: string | undefined, otherwise: T): T {
  return known.find((one) => one === text) ?? otherwise;
}
