// The prescription form's rules: RX.json's ranges (docs/formats.md), and what an optician would ask about.

export interface EyeOrder {
  sph_d: number;
  cyl_d?: number;
  axis_deg?: number;
  add_d?: number;
  pd_mm?: number;
  height_mm?: number;
}

/** RX.json. */
export interface Prescription {
  format: 'annulus-rx';
  version: 1;
  date: string;
  prescriber: string;
  refracted_vertex_mm?: number;
  right: EyeOrder;
  left: EyeOrder;
  centration: { status: 'estimate' } | { status: 'confirmed'; confirmed_by: string };
}

export type EyeField = keyof EyeOrder;
export type Eye = 'right' | 'left';

/** As it was typed: text by field. */
export type EyeText = Record<EyeField, string>;
export interface PrescriptionText {
  date: string;
  prescriber: string;
  vertex: string;
  confirmed_by: string;
  right: EyeText;
  left: EyeText;
}

/** Lowest and highest value and usual step of each number. */
export const eyeFields: Record<EyeField, { low: number; high: number; step: number; unit: string }> = {
  sph_d: { low: -30, high: 30, step: 0.25, unit: 'D' },
  cyl_d: { low: -15, high: 15, step: 0.25, unit: 'D' },
  axis_deg: { low: 0, high: 180, step: 1, unit: '°' },
  add_d: { low: 0.25, high: 4, step: 0.25, unit: 'D' },
  pd_mm: { low: 20, high: 45, step: 0.5, unit: 'mm' },
  height_mm: { low: 5, high: 60, step: 0.5, unit: 'mm' },
};
export const vertexRange = { low: 5, high: 25 };

/** Something to be put right (error) or looked at again (question); keys of the words of the page. */
export interface Finding {
  kind: 'error' | 'question';
  where: string;
  word: FindingWord;
  values?: Record<string, string | number>;
}
export type FindingWord =
  | 'rx_not_a_number' | 'rx_range' | 'rx_missing' | 'rx_axis_missing' | 'rx_axis_alone' | 'rx_sum' | 'rx_date' | 'rx_prescriber'
  | 'rx_quarter' | 'rx_signs' | 'rx_cyl_signs' | 'rx_pd_apart' | 'rx_add_differs' | 'rx_pd_one';

export interface CheckedPrescription {
  /** Null while there is an error. */
  prescription: Prescription | null;
  findings: Finding[];
}

/** A number as people type it: also with comma, with + and with a real minus sign. NaN if it is none. */
export function typedNumber(text: string): number {
  const plain = text.trim().replace(',', '.').replace('−', '-').replace(/^\+/, '');
  return /^-?(\d+\.?\d*|\.\d+)$/.test(plain) ? Number(plain) : NaN;
}

export function checkPrescription(text: PrescriptionText): CheckedPrescription {
  const findings: Finding[] = [];
  const error = (where: string, word: FindingWord, values?: Record<string, string | number>): void => {
    findings.push({ kind: 'error', where, word, ...(values && { values }) });
  };
  if (!isDate(text.date)) error('date', 'rx_date');
  if (text.prescriber.trim() === '') error('prescriber', 'rx_prescriber');
  const vertex = numberIn(text.vertex, 'vertex', vertexRange, error);
  const right = eyeOf(text.right, 'right', error);
  const left = eyeOf(text.left, 'left', error);
  if (!right || !left || findings.length > 0) return { prescription: null, findings };
  findings.push(...questionsOf(right, left));
  const confirmed = text.confirmed_by.trim();
  return {
    prescription: {
      format: 'annulus-rx',
      version: 1,
      date: text.date,
      prescriber: text.prescriber.trim(),
      ...(vertex !== null && { refracted_vertex_mm: vertex }),
      right,
      left,
      centration: confirmed ? { status: 'confirmed', confirmed_by: confirmed } : { status: 'estimate' },
    },
    findings,
  };
}

type Report = (where: string, word: FindingWord, values?: Record<string, string | number>) => void;

/** Null for an empty text or one that is wrong (which is reported). */
function numberIn(text: string, where: string, range: { low: number; high: number }, report: Report): number | null {
  if (text.trim() === '') return null;
  const value = typedNumber(text);
  if (Number.isNaN(value)) report(where, 'rx_not_a_number');
  else if (value < range.low || value > range.high) report(where, 'rx_range', { low: range.low, high: range.high });
  else return value;
  return null;
}

function eyeOf(text: EyeText, eye: Eye, report: Report): EyeOrder | null {
  const value = (field: EyeField): number | null => numberIn(text[field], `${eye}.${field}`, eyeFields[field], report);
  const sph = value('sph_d');
  if (text.sph_d.trim() === '') report(`${eye}.sph_d`, 'rx_missing');
  const cyl = value('cyl_d');
  const axis = value('axis_deg');
  const [add, pd, height] = [value('add_d'), value('pd_mm'), value('height_mm')];
  if (cyl !== null && cyl !== 0 && text.axis_deg.trim() === '') report(`${eye}.axis_deg`, 'rx_axis_missing');
  if (axis !== null && text.cyl_d.trim() === '') report(`${eye}.cyl_d`, 'rx_axis_alone');
  if (sph !== null && Math.abs(sph + (cyl ?? 0)) > 30) report(`${eye}.cyl_d`, 'rx_sum');
  if (sph === null) return null;
  return {
    sph_d: sph,
    ...(cyl !== null && cyl !== 0 && { cyl_d: cyl }),
    ...(cyl !== null && cyl !== 0 && axis !== null && { axis_deg: axis }),
    ...(add !== null && { add_d: add }),
    ...(pd !== null && { pd_mm: pd }),
    ...(height !== null && { height_mm: height }),
  };
}

/** What may be right but seldom is. */
function questionsOf(right: EyeOrder, left: EyeOrder): Finding[] {
  const findings: Finding[] = [];
  const ask = (where: string, word: FindingWord): void => void findings.push({ kind: 'question', where, word });
  for (const [eye, order] of [['right', right], ['left', left]] as const) {
    for (const field of ['sph_d', 'cyl_d', 'add_d'] as const) {
      const value = order[field];
      if (value !== undefined && !Number.isInteger(Math.round(value * 1e6) / 1e6 / 0.125)) ask(`${eye}.${field}`, 'rx_quarter');
    }
  }
  if (right.sph_d * left.sph_d < 0 && Math.abs(right.sph_d - left.sph_d) >= 1) ask('left.sph_d', 'rx_signs');
  if ((right.cyl_d ?? 0) * (left.cyl_d ?? 0) < 0) ask('left.cyl_d', 'rx_cyl_signs');
  if (right.add_d !== left.add_d) ask('left.add_d', 'rx_add_differs');
  if ((right.pd_mm === undefined) !== (left.pd_mm === undefined)) ask(right.pd_mm === undefined ? 'right.pd_mm' : 'left.pd_mm', 'rx_pd_one');
  else if (Math.abs((right.pd_mm ?? 0) - (left.pd_mm ?? 0)) > 4) ask('left.pd_mm', 'rx_pd_apart');
  return findings;
}

function isDate(text: string): boolean {
  const match = /^(\d{4})-(\d{2})-(\d{2})$/.exec(text);
  if (!match) return false;
  const date = new Date(`${text}T00:00:00Z`);
  return !Number.isNaN(date.getTime()) && date.toISOString().startsWith(text);
}

const emptyEye: EyeText = { sph_d: '', cyl_d: '', axis_deg: '', add_d: '', pd_mm: '', height_mm: '' };

/** The form's texts of a prescription; null: an empty form of `today` (YYYY-MM-DD). */
export function textOf(prescription: Prescription | null, today: string): PrescriptionText {
  if (!prescription) return { date: today, prescriber: '', vertex: '12', confirmed_by: '', right: { ...emptyEye }, left: { ...emptyEye } };
  const eye = (order: EyeOrder): EyeText => {
    const texts = { ...emptyEye };
    for (const field of Object.keys(emptyEye) as EyeField[]) {
      const value = order[field];
      if (value !== undefined) texts[field] = field.endsWith('_d') ? signed(value) : String(value);
    }
    return texts;
  };
  return {
    date: prescription.date,
    prescriber: prescription.prescriber,
    vertex: String(prescription.refracted_vertex_mm ?? ''),
    confirmed_by: prescription.centration.status === 'confirmed' ? prescription.centration.confirmed_by : '',
    right: eye(prescription.right),
    left: eye(prescription.left),
  };
}

/** "+1.25", "-0.50", as prescriptions are written; more digits where the number has more. */
export function signed(dioptres: number): string {
  const text = Number.isInteger(Math.round(dioptres * 1e6) / 1e4) ? Math.abs(dioptres).toFixed(2) : String(Math.abs(dioptres));
  return (dioptres < 0 ? '-' : dioptres > 0 ? '+' : '') + text;
}
