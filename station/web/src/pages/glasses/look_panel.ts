// Colour, material and texture of the frame's upper and lower half (paper 000, fig. 23).
import { h } from '../../core/dom';
import { check } from '../../core/ui';
import { tGlasses } from '../../words/glasses';
import { colourPicker } from './colour_picker';
import { segmented, sliderRow } from './controls';
import { activeDesign, halfOf, materials, patterns, withHalf, type Half, type HalfLook } from './design';
import type { Desk } from './desk';
import { whileOpen, type Panel } from './shape_panel';

export function lookPanel(desk: Desk): Panel {
  let half: Half = 'upper';
  const change = (key: string, label: string, next: Partial<HalfLook>): void =>
    desk.changeDesign(`${tGlasses(half)}: ${label}`, `${half} ${key}`, (design) => withHalf(design, half, next));
  const settled = (): void => desk.settle();
  const halves = segmented<Half>(tGlasses('half'), [['upper', tGlasses('upper')], ['lower', tGlasses('lower')]], (value) => {
    half = value;
    show();
  });
  const same = check(tGlasses('lower_as_upper'), true, (checked) => {
    if (!checked) half = 'lower';
    desk.changeDesign(tGlasses('lower_as_upper'), null, (design) => ({
      ...design,
      look: { ...design.look, lower: checked ? null : { ...design.look.upper } },
    }));
    if (checked) half = 'upper';
    show();
  });
  const picker = colourPicker(desk.api, desk.catalogue.colours, (colour, key) => change(`colour ${key}`, tGlasses('colour'), { colour }), settled);
  const material = segmented(tGlasses('material'), materials.map((one) => [one, tGlasses(one)] as const), (value) => change('material', tGlasses('material'), { material: value }));
  const pattern = segmented(tGlasses('texture'), patterns.map((one) => [one, tGlasses(one)] as const), (value) => change('pattern', tGlasses('texture'), { pattern: value }));
  const scale = sliderRow(tGlasses('texture_scale'), { low: 0.1, high: 10, step: 0.1, unit: '×' }, (value) => change('scale', tGlasses('texture_scale'), { scale: value }), settled);
  const show = (): void => {
    const { look } = activeDesign(desk.bench.value);
    if (half === 'lower' && !look.lower) half = 'upper';
    const one = halfOf(look, half);
    halves.set(half);
    halves.root.hidden = look.lower === null;
    same.input.checked = look.lower === null;
    picker.set(one.colour);
    material.set(one.material);
    pattern.set(one.pattern);
    scale.set(one.scale);
    scale.root.hidden = one.pattern === 'plain';
  };
  const root = h('div', { class: 'stack' }, same.root, halves.root, picker.root, material.root, pattern.root, scale.root);
  const end = desk.bench.watch(whileOpen(root, show));
  return {
    root,
    show,
    end: () => {
      end();
      picker.end();
    },
  };
}
