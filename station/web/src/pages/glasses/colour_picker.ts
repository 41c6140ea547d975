// A colour chosen as in paper 000, §6.1: eight samples, a bar, red, green and blue, then darker ⇔ brighter and
// dull ⇔ vivid by the server's transform to hue, value and chroma.
import { h, replace } from '../../core/dom';
import { tGlasses } from '../../words/glasses';
import type { GlassesApi, Hvc } from './api';
import { hexOf, hueOf, plainColour, vividOfHue, type ColourChoice, type Rgb } from './colour';
import { colourChip, sliderRow, swatches } from './controls';
import { NewestOnly } from './newest_only';

export interface ColourPicker {
  root: HTMLElement;
  set(choice: ColourChoice): void;
  end(): void;
}

const sampleNames = ['black', 'brown', 'amber', 'red', 'green', 'blue', 'silver', 'gold'] as const;

/** `change` is told of every new choice, `settled` when a movement is over. */
export function colourPicker(api: GlassesApi, samples: readonly Rgb[], change: (choice: ColourChoice, key: string) => void, settled: () => void): ColourPicker {
  let choice = plainColour([0, 0, 0]);
  const shown = h('div', { class: 'colour-shown' });
  const take = (key: string, next: Partial<ColourChoice>): void => {
    choice = { ...choice, ...next };
    show();
    change(choice, key);
  };
  const bar = sliderRow(tGlasses('colour_bar'), { low: 0, high: 360, step: 1, unit: '°', bar: 'hue-bar' }, (hue) => take('bar', plainColour(vividOfHue(hue))), settled);
  const channels = ([0, 1, 2] as const).map((i) =>
    sliderRow(tGlasses((['red', 'green', 'blue'] as const)[i]), { low: 0, high: 255, step: 1, unit: '', bar: `bar-${'rgb'[i]}` }, (value) => {
      const base: Rgb = [...choice.base];
      base[i] = value;
      take('rgb', { base });
    }, settled));
  const share = { low: -1, high: 1, step: 0.01, unit: '' };
  const brighter = sliderRow(tGlasses('brighter'), { ...share, lowWord: tGlasses('darker_word'), highWord: tGlasses('brighter_word') }, (value) => take('brighter', { brighter: value }), settled);
  const vivid = sliderRow(tGlasses('vivid'), { ...share, lowWord: tGlasses('dull_word'), highWord: tGlasses('vivid_word') }, (value) => take('vivid', { vivid: value }), settled);
  const ask = new NewestOnly(
    (one: ColourChoice) => api.colour(one.base, changeOf(one)),
    (answer, question) => question === choice && describe(answer.rgb, answer.hvc, answer.clipped),
    () => describe(choice.base, null, false),
  );
  const describe = (rgb: Rgb, hvc: Hvc | null, clipped: boolean): void => {
    const munsell = hvc ? ` · H ${hvc.hue.toFixed(1)} V ${hvc.value.toFixed(1)} C ${hvc.chroma.toFixed(1)}` : '';
    replace(shown, colourChip(rgb), h('span', null, `${hexOf(rgb)}${munsell}`), clipped ? h('span', { class: 'muted' }, tGlasses('clipped')) : null);
  };
  const show = (): void => {
    channels.forEach((row, i) => row.set(choice.base[i]!));
    bar.set(hueOf(choice.base));
    brighter.set(choice.brighter);
    vivid.set(choice.vivid);
    ask.ask(choice);
  };
  const names = sampleNames.map((name) => tGlasses(name));
  return {
    root: h('div', { class: 'stack' }, shown,
      swatches(tGlasses('samples'), samples, names, (base) => {
        take('sample', plainColour(base));
        settled();
      }),
      bar.root, brighter.root, vivid.root, h('details', { class: 'more' }, h('summary', null, tGlasses('rgb')), ...channels.map((row) => row.root))),
    set: (next) => {
      if (JSON.stringify(next) === JSON.stringify(choice)) return;
      choice = next;
      show();
    },
    end: () => ask.end(),
  };
}

function changeOf(choice: ColourChoice): { value?: number; chroma?: number } {
  return { ...(choice.brighter !== 0 && { value: choice.brighter }), ...(choice.vivid !== 0 && { chroma: choice.vivid }) };
}
