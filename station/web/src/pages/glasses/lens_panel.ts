// The lenses' colour, transmittance, coating and power, and the prescription that takes the power's place.
import { h } from '../../core/dom';
import { check } from '../../core/ui';
import { tGlasses } from '../../words/glasses';
import { colourPicker } from './colour_picker';
import { segmented, sliderRow } from './controls';
import { activeDesign, coatings, withLens, type LensLook } from './design';
import type { Desk } from './desk';
import { prescriptionForm } from './prescription_form';
import { whileOpen, type Panel } from './shape_panel';

export function lensPanel(desk: Desk): Panel {
  const change = (key: string, label: string, next: Partial<LensLook>): void =>
    desk.changeDesign(`${tGlasses('lenses')}: ${label}`, `lens ${key}`, (design) => withLens(design, next));
  const settled = (): void => desk.settle();
  const percent = { low: 0, high: 100, step: 1, unit: '%' };
  const through = sliderRow(tGlasses('transmittance'), percent, (value) => change('transmittance', tGlasses('transmittance'), { transmittance: value / 100 }), settled);
  const gradient = check(tGlasses('gradient'), false, (checked) => {
    const { lens } = activeDesign(desk.bench.value).look;
    change('gradient', tGlasses('gradient'), { lower: checked ? lens.transmittance : null });
    settled();
  });
  const lower = sliderRow(tGlasses('lower_transmittance'), percent, (value) => change('lower', tGlasses('lower_transmittance'), { lower: value / 100 }), settled);
  const coating = segmented(tGlasses('coating'), coatings.map((one) => [one, tGlasses(one)] as const), (value) => change('coating', tGlasses('coating'), { coating: value }));
  const power = sliderRow(tGlasses('power'), { low: -10, high: 10, step: 0.25, unit: 'D' }, (value) => change('power', tGlasses('power'), { power_d: value }), settled);
  const tint = colourPicker(desk.api, desk.catalogue.colours, (colour, key) => change(`tint ${key}`, tGlasses('tint'), { tint: colour }), settled);
  const form = prescriptionForm(desk);
  const show = (): void => {
    const { prescription } = desk.bench.value;
    const { lens } = activeDesign(desk.bench.value).look;
    through.set(100 * lens.transmittance);
    gradient.input.checked = lens.lower !== null;
    lower.root.hidden = lens.lower === null;
    lower.set(100 * (lens.lower ?? lens.transmittance));
    coating.set(lens.coating);
    power.set(lens.power_d);
    power.root.hidden = prescription !== null;
    tint.set(lens.tint);
  };
  const root = h('div', { class: 'stack' }, through.root, gradient.root, lower.root, power.root, coating.root,
    h('h3', null, tGlasses('tint')), tint.root, h('h3', null, tGlasses('prescription')), form.root);
  const end = desk.bench.watch(whileOpen(root, show));
  return {
    root,
    show: () => {
      show();
      form.show();
    },
    end: () => {
      end();
      tint.end();
      form.end();
    },
  };
}
