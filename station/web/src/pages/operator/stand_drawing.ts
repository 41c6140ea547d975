// How to stand: a person on the foot marks within the ring, arms held away from the body.
import { svg } from '../../core/dom';
import { tOperator as t } from '../../words/operator';

const kTrunk =
  'M187 118q-2 14-14 19l-22 8q-18 6-26 24L84 262q-5 12 5 17t16-6l46-84 6 52q-8 44-6 74l6 92q2 26 8 60l2 22h20l4-70 13-102 ' +
  '13 102 4 70h20l2-22q6-34 8-60l6-92q2-30-6-74l6-52 46 84q6 11 16 6t5-17l-41-93q-8-18-26-24l-22-8q-12-5-14-19z';

export function standDrawing(): SVGElement {
  const label = (x: number, y: number, text: string, toX: number, toY: number, anchor = 'start') => [
    svg('line', { x1: anchor === 'start' ? x - 6 : x + 6, y1: y - 5, x2: toX, y2: toY, class: 'pointer' }),
    svg('text', { x, y, 'text-anchor': anchor, class: 'label' }, text),
  ];
  return svg(
    'svg',
    { viewBox: '10 30 680 520', class: 'stand-drawing', role: 'img', 'aria-label': t('stand_drawing') },
    // Floor and foot marks.
    svg('ellipse', { cx: 200, cy: 503, rx: 176, ry: 40, class: 'floor' }),
    svg('ellipse', { cx: 172, cy: 516, rx: 24, ry: 15, class: 'mark' }),
    svg('ellipse', { cx: 228, cy: 516, rx: 24, ry: 15, class: 'mark' }),
    // The half of the ring behind the person, the person, the half before.
    svg('path', { d: 'M24 250a176 40 0 0 1 352 0', class: 'ring far' }),
    svg(
      'g',
      { transform: 'translate(0 28)', class: 'person' },
      svg('ellipse', { cx: 200, cy: 68, rx: 26, ry: 33 }),
      svg('rect', { x: 187, y: 90, width: 26, height: 44, rx: 8 }),
      svg('path', { d: kTrunk }),
      svg('ellipse', { cx: 173, cy: 490, rx: 14, ry: 8 }),
      svg('ellipse', { cx: 227, cy: 490, rx: 14, ry: 8 }),
    ),
    svg('path', { d: 'M24 250a176 40 0 0 0 352 0', class: 'ring' }),
    // The way of the ring.
    svg('path', { d: 'M392 150v200m0 0l-9-16m9 16l9-16M392 150l-9 16m9-16l9 16', class: 'arrow' }),
    ...label(300, 90, t('stand_look'), 226, 92),
    ...label(420, 256, t('stand_ring'), 376, 250),
    ...label(338, 396, t('stand_arms'), 300, 300),
    ...label(338, 470, t('stand_feet'), 252, 514),
  );
}
