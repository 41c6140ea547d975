import { afterEach, describe, expect, it } from 'vitest';
import { language } from '../core/words';
import { adjustedWords, contactWord, placementWords, rankWords } from './glasses';

afterEach(() => language.set('en'));

describe('sentences of the station about a frame', () => {
  const adjusted = 'bridge-height: 45.000 mm given, 40.250 mm used: it starts beside the straight sides';
  const goal = { id: 'pd_right', term: 'PD', value: 33, low: 28, high: 31, met: false, advice: 'the right lens’ centre is 2.0 mm too far in: choose a wider frame' };

  it('are as they came in English', () => {
    expect(adjustedWords(adjusted)).toBe(adjusted);
    expect(placementWords('last', 'where it was')).toBe('where it was');
    expect(rankWords({ why: goal.advice, goals: [goal] })).toBe(goal.advice);
  });

  it('leave no English in Japanese', () => {
    language.set('ja');
    const sentences = [
      adjustedWords(adjusted),
      adjustedWords('bridge: keyhole given, saddle used: a keyhole grows from rims and there are none'),
      adjustedWords('face-form: 12.00 degrees given, 10.00 degrees used: too much'),
      ...['fit', 'last', 'paper'].map((placement) => placementWords(placement, 'text')),
      rankWords({ why: goal.advice, goals: [goal] }),
      rankWords({ why: 'fits' }),
      rankWords({ why: 'rim_right would have to enter the head by 1.2 mm: choose a wider frame' }),
      rankWords({ why: 'pad_left does not touch the nose: 1.0 mm are left; bridge or rims meet it first' }),
      ...['pad_right', 'pad_left', 'bridge_right', 'bridge_left', 'temple_right', 'temple_left'].map(contactWord),
    ];
    for (const sentence of sentences) expect(sentence.replace(/ mm\b/g, '')).not.toMatch(/[A-Za-z]{2}/);
    expect(sentences[0]).toContain('45.000 mm → 40.250 mm');
  });
});
