import { afterEach, describe, expect, it } from 'vitest';
import { language } from '../../core/words';
import { directionText, placementText, targetName } from './target_place';

const place = { kind: 'cylinder', radius_mm: 150, x_mm: 0, y_mm: 0, tilt_deg: 0, tilt_to_deg: 0, turn_deg: null, verify: false };
afterEach(() => language.set('en'));

describe('where a target is to stand, in words', () => {
  it('is the middle, or so far aside', () => {
    expect(placementText(place)).toBe('cylinder, radius 150 mm; in the middle; upright');
    expect(placementText({ ...place, x_mm: -90, y_mm: 63.4 })).toBe('cylinder, radius 150 mm; 90 mm to the left and 63 mm to the front; upright');
  });
  it('says how it leans and where its mark points', () => {
    expect(placementText({ ...place, x_mm: 110, tilt_deg: 7, tilt_to_deg: 90, turn_deg: 60 })).toBe('cylinder, radius 150 mm; 110 mm to the right; its top leans by 7° to the front (90°); its mark points to 60°');
  });
  it('is there in Japanese', () => {
    language.set('ja');
    expect(placementText({ ...place, x_mm: 110, tilt_deg: 7, tilt_to_deg: 270 })).toBe('円筒 半径150 mm、右へ110 mm、上端を後 (270°)へ7°傾ける');
  });
});

it('directions are the subject’s: the right is 0°, the front 90°', () => {
  expect([0, 44, 90, 180, 270, -45].map(directionText)).toEqual(['right (0°)', 'front right (44°)', 'front (90°)', 'left (180°)', 'back (270°)', 'back right (315°)']);
});

it('a target has a name that can be read', () => {
  expect(targetName('cylinder:radius_mm=150,u_mm=0.02')).toBe('cylinder, radius 150 mm, U 0.02 mm');
  expect(targetName('cylinder:radius_mm=70,u_mm=0.02,serial=C-70')).toBe('cylinder, radius 70 mm, U 0.02 mm (C-70)');
  expect(targetName('plane')).toBe('board');
});
