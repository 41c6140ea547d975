import { describe, expect, it } from 'vitest';
import { checkPrescription, signed, textOf, typedNumber, type EyeText, type PrescriptionText } from './prescription';

const eye = (change: Partial<EyeText> = {}): EyeText => ({ sph_d: '-4.00', cyl_d: '-0.75', axis_deg: '90', add_d: '', pd_mm: '31.5', height_mm: '', ...change });
const form = (change: Partial<PrescriptionText> = {}): PrescriptionText => ({ date: '2026-05-04', prescriber: 'Dr. Example', vertex: '12', confirmed_by: '', right: eye(), left: eye({ pd_mm: '32' }), ...change });
const words = (text: PrescriptionText): string[] => checkPrescription(text).findings.map((finding) => `${finding.where} ${finding.word}`);

describe('a prescription', () => {
  it('becomes RX.json', () => {
    expect(checkPrescription(form()).prescription).toEqual({
      format: 'annulus-rx',
      version: 1,
      date: '2026-05-04',
      prescriber: 'Dr. Example',
      refracted_vertex_mm: 12,
      right: { sph_d: -4, cyl_d: -0.75, axis_deg: 90, pd_mm: 31.5 },
      left: { sph_d: -4, cyl_d: -0.75, axis_deg: 90, pd_mm: 32 },
      centration: { status: 'estimate' },
    });
  });

  it('is confirmed by a name', () => {
    expect(checkPrescription(form({ confirmed_by: ' A. Optician ' })).prescription?.centration).toEqual({ status: 'confirmed', confirmed_by: 'A. Optician' });
  });

  it('leaves a cylinder of nought and its axis out', () => {
    expect(checkPrescription(form({ right: eye({ cyl_d: '0', axis_deg: '' }) })).prescription?.right).toEqual({ sph_d: -4, pd_mm: 31.5 });
  });

  it.each<[string, Partial<PrescriptionText>, string]>([
    ['a missing sphere', { right: eye({ sph_d: '' }) }, 'right.sph_d rx_missing'],
    ['text for a number', { right: eye({ sph_d: 'minus four' }) }, 'right.sph_d rx_not_a_number'],
    ['a sphere out of range', { left: eye({ sph_d: '-31', cyl_d: '', axis_deg: '' }) }, 'left.sph_d rx_range'],
    ['a cylinder without an axis', { right: eye({ axis_deg: '' }) }, 'right.axis_deg rx_axis_missing'],
    ['an axis without a cylinder', { right: eye({ cyl_d: '' }) }, 'right.cyl_d rx_axis_alone'],
    ['an axis beyond 180', { right: eye({ axis_deg: '181' }) }, 'right.axis_deg rx_range'],
    ['sphere and cylinder beyond 30 D', { right: eye({ sph_d: '-29', cyl_d: '-2' }) }, 'right.cyl_d rx_sum'],
    ['a date that is none', { date: '2026-02-30' }, 'date rx_date'],
    ['nobody who prescribed it', { prescriber: '  ' }, 'prescriber rx_prescriber'],
    ['an addition that is too small', { right: eye({ add_d: '0.1' }) }, 'right.add_d rx_range'],
  ])('is refused with %s', (_, change, word) => {
    expect(checkPrescription(form(change)).prescription).toBeNull();
    expect(words(form(change))).toContain(word);
  });

  it.each<[string, Partial<PrescriptionText>, string]>([
    ['signs that differ', { left: eye({ sph_d: '+2' }) }, 'left.sph_d rx_signs'],
    ['cylinders of two signs', { left: eye({ cyl_d: '+0.75' }) }, 'left.cyl_d rx_cyl_signs'],
    ['steps that no trial lens has', { right: eye({ sph_d: '-4.1' }) }, 'right.sph_d rx_quarter'],
    ['PDs far apart', { left: eye({ pd_mm: '38' }) }, 'left.pd_mm rx_pd_apart'],
    ['one PD only', { left: eye({ pd_mm: '' }) }, 'left.pd_mm rx_pd_one'],
    ['one addition only', { left: eye({ add_d: '2' }) }, 'left.add_d rx_add_differs'],
  ])('is questioned, not refused, for %s', (_, change, word) => {
    const checked = checkPrescription(form(change));
    expect(checked.prescription).not.toBeNull();
    expect(checked.findings.map((finding) => `${finding.where} ${finding.word}`)).toEqual([word]);
    expect(checked.findings[0]?.kind).toBe('question');
  });

  it('comes back into the form as it was', () => {
    const { prescription } = checkPrescription(form());
    expect(textOf(prescription, '2026-01-01').right).toEqual(eye());
    expect(textOf(null, '2026-01-01').date).toBe('2026-01-01');
  });
});

describe('numbers as people type them', () => {
  it.each<[string, number]>([['-4,25', -4.25], ['+2', 2], ['−1.5', -1.5], [' .75 ', 0.75]])('%s', (text, value) => {
    expect(typedNumber(text)).toBe(value);
  });

  it('are not guessed', () => {
    for (const text of ['', '1e3', '0x10', '4 D', '--1', 'Infinity']) expect(typedNumber(text)).toBeNaN();
  });

  it('are written with sign and two decimals', () => {
    expect([1.25, -0.5, 0, -4.125].map(signed)).toEqual(['+1.25', '-0.50', '0.00', '-4.125']);
  });
});
