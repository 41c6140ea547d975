// Controls of the designer: sliders with numbers, choices side by side, colour samples.
import { h } from '../../core/dom';
import { newId } from '../../core/ui';
import { hexOf, type Rgb } from './colour';

export interface SliderLook {
  low: number;
  high: number;
  step: number;
  unit: string;
  /** Words at the two ends. */
  lowWord?: string;
  highWord?: string;
  /** Class of the bar, for those that show colours. */
  bar?: string;
}

export interface SliderRow {
  root: HTMLElement;
  /** Shows a value without telling. */
  set(value: number): void;
}

/** How many decimals a step has. */
function decimals(step: number): number {
  return String(step).split('.')[1]?.length ?? 0;
}

/**
 * A slider with − and + for single steps and a number to type. `change` is told while it moves, `settled` when a
 * movement is over.
 */
export function sliderRow(label: string, look: SliderLook, change: (value: number) => void, settled: () => void): SliderRow {
  const id = newId('slider');
  const digits = decimals(look.step);
  const held = (value: number): number => Number(Math.max(look.low, Math.min(look.high, value)).toFixed(digits));
  const range = h('input', { type: 'range', id, min: look.low, max: look.high, step: look.step, class: look.bar });
  const number = h('input', { type: 'number', class: 'slider-number', min: look.low, max: look.high, step: look.step, 'aria-label': `${label}, ${look.unit}` });
  const show = (value: number): void => {
    range.value = String(value);
    number.value = value.toFixed(digits);
  };
  const tell = (value: number): void => {
    show(held(value));
    change(held(value));
  };
  range.addEventListener('input', () => tell(Number(range.value)));
  range.addEventListener('change', settled);
  number.addEventListener('change', () => {
    if (number.value !== '' && !Number.isNaN(number.valueAsNumber)) tell(number.valueAsNumber);
    else show(Number(range.value));
    settled();
  });
  const nudge = (text: string, steps: number): HTMLElement =>
    h('button', {
      type: 'button',
      class: 'nudge',
      'aria-label': `${label} ${text}`,
      onclick: () => {
        tell(Number(range.value) + steps * look.step);
        settled();
      },
    }, text);
  const words = look.lowWord ? h('span', { class: 'slider-words', 'aria-hidden': 'true' }, `${look.lowWord} ⇔ ${look.highWord ?? ''}`) : null;
  return {
    root: h('div', { class: 'slider-row' },
      h('div', { class: 'slider-head' }, h('label', { for: id }, label), words),
      h('div', { class: 'slider-line' }, nudge('−', -1), range, nudge('+', 1), number, h('span', { class: 'unit' }, look.unit))),
    set: (value) => {
      // A number that is being typed is not changed under the hand.
      if (document.activeElement !== number) show(held(value));
    },
  };
}

export interface Segmented<T extends string> {
  root: HTMLElement;
  set(value: T): void;
}

/** One of a few, all in sight; radio buttons for keyboard and screen reader. */
export function segmented<T extends string>(label: string, options: readonly (readonly [value: T, text: string])[], change: (value: T) => void): Segmented<T> {
  const name = newId('choice');
  const inputs = options.map(([value, text]) => {
    const input = h('input', { type: 'radio', name, value, class: 'hidden-text', onchange: () => change(value) });
    return { value, input, root: h('label', { class: 'segment' }, input, h('span', null, text)) };
  });
  return {
    root: h('fieldset', { class: 'segmented' }, h('legend', null, label), h('div', { class: 'segments' }, ...inputs.map((one) => one.root))),
    set: (value) => {
      for (const one of inputs) one.input.checked = one.value === value;
    },
  };
}

/** A square of a colour. */
export function colourChip(rgb: Rgb): HTMLElement {
  const chip = h('span', { class: 'chip', 'aria-hidden': 'true' });
  chip.style.backgroundColor = hexOf(rgb);
  return chip;
}

/** Samples to choose from. `names` are read out, in the samples' order. */
export function swatches(label: string, colours: readonly Rgb[], names: readonly string[], choose: (colour: Rgb) => void): HTMLElement {
  return h('div', { class: 'swatches', role: 'group', 'aria-label': label },
    ...colours.map((colour, i) => {
      const name = names[i] ?? hexOf(colour);
      const swatch = h('button', { type: 'button', class: 'swatch', 'aria-label': name, title: name, onclick: () => choose(colour) });
      swatch.style.backgroundColor = hexOf(colour);
      return swatch;
    }));
}
