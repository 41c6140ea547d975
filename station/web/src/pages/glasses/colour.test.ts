import { describe, expect, it } from 'vitest';
import { choiceOfLook, contrast, hexOf, hueOf, linearOf, lookColour, plainColour, rgbOfHex, vividOfHue, type Rgb } from './colour';

describe('colours', () => {
  it('are written and read as #rrggbb', () => {
    expect(hexOf([60, 42, 30])).toBe('#3c2a1e');
    expect(hexOf([-5, 255.4, 300])).toBe('#00ffff');
    expect(rgbOfHex('#3C2a1e')).toEqual([60, 42, 30]);
    expect(rgbOfHex('#f80')).toEqual([255, 136, 0]);
    expect(rgbOfHex('red')).toBeNull();
    expect(rgbOfHex('#12345')).toBeNull();
  });

  // IEC 61966-2-1: linear = ((c + 0.055) / 1.055)^2.4; the values of 0, 10, 128, 188 and 255 from its table.
  it.each([[0, 0], [10, 0.003035], [128, 0.215861], [188, 0.502886], [255, 1]])('have linear light: %d → %d', (channel, linear) => {
    expect(linearOf(channel)).toBeCloseTo(linear, 5);
  });

  it('have WCAG’s contrast', () => {
    expect(contrast([0, 0, 0], [255, 255, 255])).toBeCloseTo(21, 6);
    // #767676 on white is the well-known darkest grey below 4.54.
    expect(contrast([118, 118, 118], [255, 255, 255])).toBeCloseTo(4.54, 2);
  });

  it.each<[number, Rgb]>([[0, [255, 0, 0]], [60, [255, 255, 0]], [120, [0, 255, 0]], [180, [0, 255, 255]], [240, [0, 0, 255]], [300, [255, 0, 255]], [30, [255, 128, 0]]])(
    'have hues: %d°', (hue, rgb) => {
      expect(vividOfHue(hue)).toEqual(rgb);
      expect(hueOf(rgb)).toBeCloseTo(hue, 0);
    });

  it('have no hue where they are grey', () => {
    expect(hueOf([80, 80, 80])).toBe(0);
  });

  it('keep what was changed about them', () => {
    const choice = { base: [170, 32, 48] as Rgb, brighter: 0.2, vivid: -0.35 };
    expect(lookColour(choice)).toBe('#aa2030,brighter:0.2,vivid:-0.35');
    expect(choiceOfLook('#aa2030,brighter:0.2,vivid:-0.35')).toEqual(choice);
    expect(lookColour(plainColour([0, 0, 0]))).toBe('#000000');
  });

  it('are not guessed from other forms', () => {
    for (const text of ['sample:red', 'bar:0.2', '#aa2030,brighter:2', '#aa2030,duller:1', '']) expect(choiceOfLook(text)).toBeNull();
  });
});
