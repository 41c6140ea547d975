// A ring that empties while seconds pass.
import { h, svg } from '../../core/dom';

const kRadius = 54;
const kAround = 2 * Math.PI * kRadius;

/** Runs from `seconds` to 0; `second` is told of each full one, `done` of the end. `end` stops it. */
export function countdown(label: string, seconds: number, second: (left: number) => void, done: () => void) {
  const arc = svg('circle', { cx: 64, cy: 64, r: kRadius, class: 'arc', 'stroke-dasharray': kAround, transform: 'rotate(-90 64 64)' });
  const number = svg('text', { x: 64, y: 64, 'text-anchor': 'middle', 'dominant-baseline': 'central', class: 'number' }, seconds);
  const root = h('div', { class: 'countdown', role: 'timer', 'aria-label': label }, svg('svg', { viewBox: '0 0 128 128', 'aria-hidden': 'true' }, svg('circle', { cx: 64, cy: 64, r: kRadius, class: 'track' }), arc, number));
  const until = performance.now() + seconds * 1000;
  let shown = seconds;
  const timer = setInterval(() => {
    const left = Math.max(0, (until - performance.now()) / 1000);
    arc.setAttribute('stroke-dashoffset', String(kAround * (1 - left / seconds)));
    const whole = Math.ceil(left);
    if (whole !== shown) {
      shown = whole;
      number.textContent = String(whole);
      if (whole > 0) second(whole);
    }
    if (left === 0) {
      clearInterval(timer);
      done();
    }
  }, 100);
  return { root, end: () => clearInterval(timer) };
}
