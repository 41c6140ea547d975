// Curves, by uPlot, in the page's colours.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import './charts.css';
import { h } from '../core/dom';
import { language } from '../core/words';
import { cssValue, onTheme } from './theme';

export interface Curve {
  label: string;
  /** Of the page's colours: "--accent". */
  colour: string;
  /** Points without a line between them. */
  pointsOnly?: boolean;
  dashed?: boolean;
  unit?: string;
  digits?: number;
}

export interface PlotLook {
  /** Read out instead of the picture. */
  label: string;
  /** Of the axis below, with its unit. */
  xLabel: string;
  yLabel: string;
  /** Times are seconds since 1970. */
  xTime?: boolean;
  /** Whole numbers only below (steps). */
  xWhole?: boolean;
  curves: Curve[];
  /** Between which curves (1 first: upper, lower) the area is filled. */
  band?: [upper: number, lower: number];
  /** Always within the picture. */
  yAtLeast?: [low: number, high: number];
  height?: number;
  legend?: boolean;
}

export interface Plot {
  root: HTMLElement;
  /** x, then one list per curve; null is a gap. */
  set(data: (number | null)[][]): void;
  dispose(): void;
}

export function plot(look: PlotLook): Plot {
  const root = h('div', { class: 'plot', role: 'img', 'aria-label': look.label });
  let data: (number | null)[][] = [[], ...look.curves.map(() => [])];
  let chart: uPlot | null = null;
  let width = 0;

  const build = () => {
    chart?.destroy();
    chart = null;
    if (width < 40) return;
    chart = new uPlot(optionsOf(look, width), data as uPlot.AlignedData, root);
  };
  const sizes = new ResizeObserver(() => {
    const now = Math.floor(root.clientWidth);
    if (now === width) return;
    width = now;
    if (chart) chart.setSize({ width, height: look.height ?? 240 });
    else build();
  });
  sizes.observe(root);
  const endTheme = onTheme(build);
  return {
    root,
    set(now) {
      data = now;
      if (chart) chart.setData(data as uPlot.AlignedData);
      else build();
    },
    dispose() {
      sizes.disconnect();
      endTheme();
      chart?.destroy();
      chart = null;
    },
  };
}

function optionsOf(look: PlotLook, width: number): uPlot.Options {
  const ink = cssValue('--ink');
  const axis = { stroke: ink, grid: { stroke: cssValue('--line'), width: 1 }, ticks: { stroke: cssValue('--edge'), width: 1 }, font: '13px system-ui, sans-serif', labelFont: '600 13px system-ui, sans-serif' };
  const date = new Intl.DateTimeFormat(language.value, { month: 'short', day: 'numeric', timeZone: 'UTC' });
  const clock = new Intl.DateTimeFormat(language.value, { month: 'short', day: 'numeric', hour: '2-digit', minute: '2-digit', timeZone: 'UTC' });
  const timed = (splits: number[]) => {
    const short = splits.length > 1 && splits[1]! - splits[0]! < 86400;
    return splits.map((one) => (short ? clock : date).format(one * 1000));
  };
  const below: uPlot.Axis = { ...axis, label: look.xLabel, labelSize: 24, size: 36, space: look.xTime ? 90 : 50 };
  if (look.xTime) below.values = (_, splits) => timed(splits);
  if (look.xWhole) below.incrs = [1, 2, 5, 10, 20, 50, 100];
  const options: uPlot.Options = {
    width,
    height: look.height ?? 240,
    tzDate: (time) => uPlot.tzDate(new Date(time * 1000), 'Etc/UTC'),
    padding: [8, 26, 0, 0],
    legend: { show: look.legend ?? true, live: true },
    cursor: { y: false, points: { size: 8 } },
    scales: { x: { time: look.xTime ?? false }, y: { range: (_, low, high) => yRange(look, low, high) } },
    axes: [below, { ...axis, label: look.yLabel, labelSize: 24, size: 58 }],
    series: [{ label: look.xLabel, value: (_, value) => (value === null || value === undefined ? '–' : look.xTime ? clock.format(value * 1000) : String(Number(value.toFixed(3)))) }, ...look.curves.map(seriesOf)],
  };
  if (look.band) {
    const fill = cssValue('--accent-soft');
    options.bands = [{ series: look.band, fill }];
  }
  return options;
}

function seriesOf(curve: Curve): uPlot.Series {
  const stroke = cssValue(curve.colour);
  const series: uPlot.Series = {
    label: curve.label,
    stroke,
    width: curve.pointsOnly ? 0 : 2,
    // Where there are few, lines have points, too: one alone would not be seen.
    points: curve.pointsOnly ? { show: true, size: 7, fill: stroke } : { size: 6, fill: stroke },
    value: (_, value) => (value === null || value === undefined ? '–' : `${value.toFixed(curve.digits ?? 2)}${curve.unit ? ` ${curve.unit}` : ''}`),
  };
  if (curve.dashed) series.dash = [6, 5];
  return series;
}

/** A little room above and below, and what must be seen. */
function yRange(look: PlotLook, low: number | null, high: number | null): [number, number] {
  const [atLeastLow, atLeastHigh] = look.yAtLeast ?? [low ?? 0, high ?? 1];
  const from = Math.min(low ?? atLeastLow, atLeastLow);
  const to = Math.max(high ?? atLeastHigh, atLeastHigh);
  const room = to > from ? 0.06 * (to - from) : 0.5;
  return [from === 0 ? 0 : from - room, to + room];
}
