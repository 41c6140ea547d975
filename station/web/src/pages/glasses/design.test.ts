import { describe, expect, it } from 'vitest';
import { activeDesign, designBody, firstLook, halfOf, lookBody, lookOfFile, withDesign, withHalf, withLens, type Bench, type Design } from './design';

const design: Design = { style: 'round', size: '', fields: { 'upper-outer': 4.5 }, look: firstLook() };
const bench: Bench = { a: design, b: { ...design, style: 'panto' }, active: 'b', prescription: null };

describe('a design', () => {
  it('is asked for without a size if it has none', () => {
    expect(designBody(design)).toEqual({ style: 'round', fields: { 'upper-outer': 4.5 } });
    expect(designBody({ ...design, size: 'medium' })).toEqual({ style: 'round', size: 'medium', fields: { 'upper-outer': 4.5 } });
  });

  it('is the one that is worked on', () => {
    expect(activeDesign(bench).style).toBe('panto');
    expect(activeDesign({ ...bench, b: null }).style).toBe('round');
    const changed = withDesign(bench, (one) => ({ ...one, style: 'oval' }));
    expect([changed.a.style, changed.b?.style]).toEqual(['round', 'oval']);
  });
});

describe('a look', () => {
  it('has its lower half as the upper one until it is changed', () => {
    expect(halfOf(design.look, 'lower')).toBe(design.look.upper);
    const changed = withHalf(design, 'lower', { material: 'metal' });
    expect(halfOf(changed.look, 'lower').material).toBe('metal');
    expect(halfOf(changed.look, 'upper').material).toBe('plastic');
  });

  it('is LOOK.json, and comes back from it', () => {
    const changed = withLens(withHalf(design, 'lower', { material: 'brushed', pattern: 'horn', scale: 2 }), { transmittance: 0.4, lower: 0.8, coating: 'mirror', power_d: -2 });
    const file = lookBody(changed.look);
    expect(file).toMatchObject({ format: 'annulus-look', version: 1, lens: { transmittance: 0.4, lower_transmittance: 0.8, coating: 'mirror', power_d: -2 } });
    expect(lookOfFile(JSON.parse(JSON.stringify(file)))).toEqual(changed.look);
  });

  it('takes what it does not know from a fresh one', () => {
    expect(lookOfFile({ upper: { colour: 'sample:red', material: 'wood' } })).toEqual(firstLook());
  });
});
