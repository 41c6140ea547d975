// What the booth says by a code, in the person's language: checks, warnings, notices, faults of the safety chain. For a
// code that has no words here, as of a newer booth, its own English text is shown.
import { boothWords, tBooth as t } from '../words/booth';
import { fixed } from './format';

type Key = keyof typeof boothWords;
type Values = Record<string, string | number>;

/** What happened, and what to do about it. */
export interface Said {
  text: string;
  advice: string;
}

const known = (key: string): key is Key => key in boothWords;

/** By the code if it is known, else as the station said it. */
function said(text: string, advice: string, otherwise: Said, values: Values = {}): Said {
  return known(text) && known(advice) ? { text: t(text, values), advice: t(advice, values) } : otherwise;
}

export function checkWords(name: string, otherwise: Said): Said {
  return said(`check_${name}`, `check_${name}_do`, otherwise);
}

export function chainFaultWords(fault: string, otherwise: Said): Said {
  return said(`chain_${fault}`, `chain_${fault}_do`, otherwise);
}

export interface Warning {
  code: string;
  text: string;
  values: number[];
}

/** Its numbers are {a}, {b} … in the order in which they come. */
export function warningWords(warning: Warning): string {
  const key = `warning_${warning.code}`;
  if (warning.code === 'other' || !known(key)) return warning.text;
  return t(key, Object.fromEntries(warning.values.map((value, k) => [String.fromCharCode(97 + k), fixed(value, 0)])));
}

export interface Region {
  theta_from_deg: number;
  theta_to_deg: number;
  z_min_mm: number;
  z_max_mm: number;
}

export interface Notice extends Said {
  code?: string;
  where?: Region;
  size?: number;
  unit?: string;
}

/** `scan`: how many levels were taken and planned. A notice without its numbers, of an earlier program, stays as it is. */
export function noticeWords(notice: Notice, scan: { levels: number; planned_levels: number | null }): Said {
  const { code, where, size, unit } = notice;
  if (!code) return notice;
  const counts = { levels: scan.levels, planned: scan.planned_levels ?? '?' };
  if (code === 'incomplete') return said('notice_incomplete', 'notice_incomplete_do', notice, counts);
  if (!where || size === undefined) return notice;
  return said(`notice_${code}`, `notice_${code}_do`, notice, { size: sizeWords(size, unit ?? ''), where: regionWords(where) });
}

function sizeWords(size: number, unit: string): string {
  if (unit === 'share') return `${fixed(100 * size, size < 0.1 ? 1 : 0)} %`;
  if (unit === 'mm' || unit === 's') return `${fixed(size, size < 10 ? 1 : 0)} ${unit}`;
  return fixed(size, 0);
}

/** From the subject's right, counter-clockwise seen from above. */
const sectors = ['right', 'front_right', 'front', 'front_left', 'left', 'back_left', 'back', 'back_right'] as const;

function sector(thetaDeg: number): string {
  const turned = ((thetaDeg % 360) + 360) % 360;
  return t(`sector_${sectors[Math.round(turned / 45) % sectors.length] ?? 'front'}`);
}

const allRoundDeg = 338;
const halfDeg = 132;

/** Where on the body: "front left, 1.20–1.35 m". */
export function regionWords(region: Region): string {
  const low = fixed(region.z_min_mm / 1000, 2);
  const high = fixed(region.z_max_mm / 1000, 2);
  return t('region_heights', { place: placeWords(region.theta_from_deg, region.theta_to_deg), low, high });
}

function placeWords(from: number, to: number): string {
  const width = to - from;
  const middle = from + width / 2;
  if (width >= allRoundDeg) return t('region_all_round');
  if (width > 360 - halfDeg) return t('region_all_but', { side: sector(middle + 180) });
  if (width > halfDeg) return t('region_half', { side: sector(middle) });
  // A little inwards: an end just over the border of a sector does not name it.
  const inwards = Math.min(width / 10, 6);
  const [first, last] = [sector(from + inwards), sector(to - inwards)];
  return first === last ? t('region_side', { side: first }) : t('region_from_to', { side: first, to: last });
}
