import { afterEach, describe, expect, it } from 'vitest';
import { checkWords, noticeWords, regionWords, warningWords } from './booth_said';
import { language } from './words';

afterEach(() => language.set('en'));

const region = (theta_from_deg: number, theta_to_deg: number) => ({ theta_from_deg, theta_to_deg, z_min_mm: 1200, z_max_mm: 1346 });
const scan = { levels: 90, planned_levels: 120 };

describe('what the booth says', () => {
  it('is said in the person’s language, by its code', () => {
    const english = { text: 'the axis is not homed', advice: 'home it' };
    expect(checkWords('homed', english).advice).toContain('Home');
    language.set('ja');
    expect(checkWords('homed', english).text).toBe('リングが原点にありません。');
  });

  it('is said as the booth says it if its code is not known here', () => {
    const english = { text: 'the moon is full', advice: 'wait' };
    language.set('ja');
    expect(checkWords('moon', english)).toEqual(english);
    expect(warningWords({ code: 'moon', text: 'the moon is full', values: [] })).toBe('the moon is full');
    expect(warningWords({ code: 'other', text: 'the moon is full', values: [] })).toBe('the moon is full');
    expect(noticeWords({ code: 'moon', ...english, where: region(0, 10), size: 1, unit: 'mm' }, scan)).toMatchObject(english);
  });

  it('has the numbers that came with it', () => {
    expect(warningWords({ code: 'ring_temperature', text: '', values: [38.2, 20] })).toContain('38 °C, it was calibrated at 20 °C');
    language.set('ja');
    expect(warningWords({ code: 'wall_clock_set', text: '', values: [-1500] })).toContain('-1,500');
    expect(noticeWords({ code: 'moved', text: 'x', advice: 'y', where: region(0, 360), size: 27.4, unit: 'mm' }, scan).text).toBe('お客様が約27 mm動きました。');
    expect(noticeWords({ code: 'spikes', text: 'x', advice: 'y', where: region(0, 360), size: 0.031, unit: 'share' }, scan).text).toContain('3.1 %');
    expect(noticeWords({ code: 'incomplete', text: 'x', advice: 'y' }, scan).text).toContain('120段のうち90段');
  });

  it('keeps the text of a notice whose numbers were not kept', () => {
    const old = { code: 'moved', text: 'the person moved', advice: 'stand still' };
    expect(noticeWords(old, scan)).toBe(old);
  });
});

describe('a region in words', () => {
  // 0° is the subject's right, counter-clockwise seen from above, so 90° is the front.
  it.each([
    [80, 100, 'front, 1.20–1.35 m'],
    [30, 100, 'front right to front, 1.20–1.35 m'],
    [350, 370, 'right, 1.20–1.35 m'],
    [0, 180, 'front half, 1.20–1.35 m'],
    [100, 440, 'all round, 1.20–1.35 m'],
    [110, 410, 'all but front, 1.20–1.35 m'],
  ])('from %s to %s degrees', (from, to, words) => {
    expect(regionWords(region(from, to))).toBe(words);
  });
});
