// A heat map with axes, legend, zoom and a cursor, on a canvas.
import { h, replace } from '../core/dom';
import { button } from '../core/ui';
import './charts.css';
import { type ColourTable, cssColour, diverging, sequential } from './colour_map';
import { cellSpans, type Matrix, rasterised, type Span } from './heat_map';
import { moved, placed, type Range, ticks, zoomed } from './scale';
import { tCharts } from './words';
import { channels, cssValue, ground, onTheme } from './theme';

/** One side of the map. */
export interface Side {
  whole: Range;
  label: string;
  /** Least width of a window. */
  least: number;
  spans(window: Range, pixels: number): Span[];
  /** The cell at a place of this side. */
  cellAt(value: number): number;
  /** Where a cell is (its middle). */
  placeOf(cell: number): number;
  cells: number;
  tick?(value: number): string;
  /** Ticks only at whole numbers. */
  wholeTicks?: boolean;
}

export interface HeatLook {
  label: string;
  matrix: Matrix;
  across: Side;
  down: Side;
  colours: 'sequential' | 'diverging';
  range: Range;
  /** "mm" */
  unit: string;
  height: number;
  /** Told of the cell that was picked. */
  pick(row: number, column: number): void;
  /** Told of every change of the window across (a timeline below follows it). */
  windowChanged?(window: Range): void;
}

export interface HeatView {
  root: HTMLElement;
  /** Marks a cell; null: no row or column. */
  setCursor(row: number | null, column: number | null): void;
  /** Shows so much across. */
  setWindow(window: Range): void;
  window(): Range;
  dispose(): void;
}

export const margins = { left: 108, right: 12, top: 8, bottom: 44 };

export function heatView(look: HeatLook): HeatView {
  const canvas = h('canvas', { class: 'heat-canvas', tabindex: 0, role: 'img', 'aria-label': `${look.label}. ${tCharts('map_keys')}` });
  const state = { across: { ...look.across.whole }, down: { ...look.down.whole }, row: null as number | null, column: null as number | null };
  let raster: { image: HTMLCanvasElement; key: string } | null = null;
  let wanted = 0;

  const draw = () => {
    wanted = 0;
    raster = drawMap(canvas, look, state, raster);
  };
  const ask = () => {
    if (wanted === 0) wanted = requestAnimationFrame(draw);
  };
  const setAcross = (window: Range) => {
    state.across = window;
    look.windowChanged?.(window);
    ask();
  };
  const setDown = (window: Range) => {
    state.down = window;
    ask();
  };
  const zoomBy = (factor: number, aboutX: number, aboutY: number, both: boolean) => {
    setAcross(zoomed(state.across, look.across.whole, aboutX, factor, look.across.least));
    if (both) setDown(zoomed(state.down, look.down.whole, aboutY, factor, look.down.least));
  };
  const middle = (range: Range) => (range.low + range.high) / 2;
  const about = () => (state.column === null ? middle(state.across) : look.across.placeOf(state.column));
  const reset = () => {
    setAcross({ ...look.across.whole });
    setDown({ ...look.down.whole });
  };
  const tools = toolsOf(look, (factor) => zoomBy(factor, about(), middle(state.down), false), reset);
  const root = h('div', { class: 'heat' }, canvas, tools);
  const ends = [watchPointer(canvas, look, state, { zoomBy, setAcross, setDown }), watchKeys(canvas, look, state, zoomBy, reset)];
  const sizes = new ResizeObserver(ask);
  sizes.observe(canvas);
  ends.push(() => sizes.disconnect());
  ends.push(
    onTheme(() => {
      raster = null;
      replace(tools.firstElementChild!, ...legend(look).childNodes);
      ask();
    }),
  );
  return {
    root,
    setCursor(row, column) {
      state.row = row;
      state.column = column;
      ask();
    },
    setWindow(window) {
      state.across = window;
      ask();
    },
    window: () => state.across,
    dispose() {
      if (wanted !== 0) cancelAnimationFrame(wanted);
      for (const end of ends) end();
    },
  };
}

/** Legend, and buttons for who has no wheel. */
function toolsOf(look: HeatLook, zoom: (factor: number) => void, reset: () => void): HTMLElement {
  const buttons = [button('+', () => zoom(0.5), { label: tCharts('nearer') }), button('−', () => zoom(2), { label: tCharts('further') }), button(tCharts('all'), reset)];
  return h('div', { class: 'row heat-tools' }, legend(look), h('div', { class: 'row' }, buttons));
}

/** A side whose cells are numbered: sensors, scans. */
export function indexSide(label: string, count: number, tick?: (value: number) => string): Side {
  const side: Side = {
    whole: { low: 0, high: count },
    label,
    least: Math.min(4, count),
    cells: count,
    spans: (window, pixels) => cellSpans(window, pixels, count),
    cellAt: (value) => Math.min(count - 1, Math.max(0, Math.floor(value))),
    placeOf: (cell) => cell + 0.5,
    wholeTicks: true,
  };
  if (tick) side.tick = tick;
  return side;
}

interface State {
  across: Range;
  down: Range;
  row: number | null;
  column: number | null;
}

interface Area {
  x: Range;
  y: Range;
}

function areaOf(canvas: HTMLCanvasElement): Area {
  return {
    x: { low: margins.left, high: Math.max(margins.left + 1, canvas.clientWidth - margins.right) },
    y: { low: margins.top, high: Math.max(margins.top + 1, canvas.clientHeight - margins.bottom) },
  };
}

function tableOf(look: HeatLook): ColourTable {
  return look.colours === 'sequential' ? sequential : diverging[ground()];
}

function drawMap(canvas: HTMLCanvasElement, look: HeatLook, state: State, before: { image: HTMLCanvasElement; key: string } | null) {
  const density = devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, look.height];
  if (width < 100) return before;
  canvas.style.height = `${height}px`;
  if (canvas.width !== Math.round(width * density) || canvas.height !== Math.round(height * density)) {
    canvas.width = Math.round(width * density);
    canvas.height = Math.round(height * density);
  }
  const context = canvas.getContext('2d')!;
  context.setTransform(density, 0, 0, density, 0, 0);
  context.clearRect(0, 0, width, height);
  const area = areaOf(canvas);
  const [columns, rows] = [Math.round(area.x.high - area.x.low), Math.round(area.y.high - area.y.low)];
  const key = [columns, rows, state.across.low, state.across.high, state.down.low, state.down.high].join();
  let raster = before;
  if (!raster || raster.key !== key) {
    const image = h('canvas', { width: columns, height: rows });
    const pixels = rasterised(look.matrix, look.down.spans(state.down, rows), look.across.spans(state.across, columns), {
      table: tableOf(look),
      range: look.range,
      empty: channels(cssValue('--no-return')),
    });
    image.getContext('2d')!.putImageData(new ImageData(pixels, columns, rows), 0, 0);
    raster = { image, key };
  }
  context.fillStyle = cssValue('--raised');
  context.fillRect(area.x.low, area.y.low, columns, rows);
  context.imageSmoothingEnabled = false;
  context.drawImage(raster.image, area.x.low, area.y.low, columns, rows);
  drawSides(context, look, state, area);
  drawCursor(context, look, state, area);
  return raster;
}

function drawSides(context: CanvasRenderingContext2D, look: HeatLook, state: State, area: Area): void {
  const ink = cssValue('--ink');
  context.strokeStyle = cssValue('--edge');
  context.lineWidth = 1;
  context.strokeRect(area.x.low - 0.5, area.y.low - 0.5, area.x.high - area.x.low + 1, area.y.high - area.y.low + 1);
  context.fillStyle = ink;
  context.font = '13px system-ui, sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'top';
  const shift = (side: Side) => (side.wholeTicks ? 0.5 : 0);
  for (const value of ticksOf(look.across, state.across, (area.x.high - area.x.low) / 80)) {
    const x = placed(value + shift(look.across), state.across, area.x);
    if (x < area.x.low || x > area.x.high) continue;
    context.fillRect(Math.round(x), area.y.high, 1, 5);
    context.fillText(look.across.tick?.(value) ?? String(value), x, area.y.high + 7);
  }
  context.textAlign = 'right';
  context.textBaseline = 'middle';
  for (const value of ticksOf(look.down, state.down, (area.y.high - area.y.low) / 34)) {
    const y = placed(value + shift(look.down), state.down, area.y);
    if (y < area.y.low || y > area.y.high) continue;
    context.fillRect(area.x.low - 5, Math.round(y), 5, 1);
    context.fillText(look.down.tick?.(value) ?? String(value), area.x.low - 8, y);
  }
  context.font = '600 13px system-ui, sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'bottom';
  context.fillText(look.across.label, (area.x.low + area.x.high) / 2, area.y.high + margins.bottom - 2);
  context.save();
  context.translate(30, (area.y.low + area.y.high) / 2);
  context.rotate(-Math.PI / 2);
  context.textBaseline = 'top';
  context.fillText(look.down.label, 0, 0);
  context.restore();
}

function ticksOf(side: Side, window: Range, wanted: number): number[] {
  const all = ticks(window.low, window.high, Math.max(1, wanted));
  return side.wholeTicks ? all.filter((one) => Number.isInteger(one) && one < side.whole.high) : all;
}

/** Two lines, dark with a light edge, that are seen on every colour. */
function drawCursor(context: CanvasRenderingContext2D, look: HeatLook, state: State, area: Area): void {
  const line = (x: number, y: number, width: number, height: number) => {
    context.fillStyle = '#ffffff';
    context.fillRect(x - 1, y - 1, width + 2, height + 2);
    context.fillStyle = '#000000';
    context.fillRect(x, y, width, height);
  };
  if (state.column !== null) {
    const x = Math.round(placed(look.across.placeOf(state.column), state.across, area.x));
    if (x >= area.x.low && x <= area.x.high) line(x, area.y.low, 1, area.y.high - area.y.low);
  }
  if (state.row !== null) {
    const y = Math.round(placed(look.down.placeOf(state.row), state.down, area.y));
    if (y >= area.y.low && y <= area.y.high) line(area.x.low, y, area.x.high - area.x.low, 1);
  }
}

interface Moves {
  zoomBy(factor: number, aboutX: number, aboutY: number, both: boolean): void;
  setAcross(window: Range): void;
  setDown(window: Range): void;
}

/** Press picks, dragging moves when zoomed in (else picks along), two fingers and the wheel zoom. */
function watchPointer(canvas: HTMLCanvasElement, look: HeatLook, state: State, moves: Moves): () => void {
  const places = new Map<number, { x: number; y: number }>();
  const valueAt = (x: number, y: number) => {
    const area = areaOf(canvas);
    return { across: placed(x, area.x, state.across), down: placed(y, area.y, state.down) };
  };
  const pick = (event: PointerEvent) => {
    const at = valueAt(event.offsetX, event.offsetY);
    const inside = (value: number, range: Range) => value >= range.low && value <= range.high;
    if (!inside(at.across, state.across) || !inside(at.down, state.down)) return;
    look.pick(look.down.cellAt(at.down), look.across.cellAt(at.across));
  };
  canvas.onpointerdown = (event) => {
    places.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    canvas.setPointerCapture(event.pointerId);
    if (places.size === 1) pick(event);
  };
  canvas.onpointermove = (event) => {
    const before = places.get(event.pointerId);
    if (!before) return;
    const now = { x: event.offsetX, y: event.offsetY };
    if (places.size === 2) {
      const other = [...places.entries()].find(([id]) => id !== event.pointerId)![1];
      const apart = (p: { x: number; y: number }) => Math.max(10, Math.hypot(p.x - other.x, p.y - other.y));
      const centre = valueAt((now.x + other.x) / 2, (now.y + other.y) / 2);
      moves.zoomBy(apart(before) / apart(now), centre.across, centre.down, true);
    } else if (event.shiftKey || event.buttons === 4) {
      const [from, to] = [valueAt(before.x, before.y), valueAt(now.x, now.y)];
      moves.setAcross(moved(state.across, look.across.whole, from.across - to.across));
      moves.setDown(moved(state.down, look.down.whole, from.down - to.down));
    } else {
      pick(event);
    }
    places.set(event.pointerId, now);
  };
  const end = (event: PointerEvent) => places.delete(event.pointerId);
  canvas.onpointerup = end;
  canvas.onpointercancel = end;
  const wheel = (event: WheelEvent) => {
    event.preventDefault();
    const at = valueAt(event.offsetX, event.offsetY);
    if (event.shiftKey) {
      const step = (Math.sign(event.deltaY || event.deltaX) * (state.across.high - state.across.low)) / 10;
      moves.setAcross(moved(state.across, look.across.whole, step));
      return;
    }
    moves.zoomBy(event.deltaY > 0 ? 1.25 : 0.8, at.across, at.down, event.ctrlKey);
  };
  canvas.addEventListener('wheel', wheel, { passive: false });
  return () => canvas.removeEventListener('wheel', wheel);
}

/** Arrows move the cursor by a cell (with Shift by ten), + and − zoom, 0 shows all. */
function watchKeys(canvas: HTMLCanvasElement, look: HeatLook, state: State, zoomBy: Moves['zoomBy'], reset: () => void): () => void {
  canvas.onkeydown = (event) => {
    const far = event.shiftKey ? 10 : 1;
    const across = event.key === 'ArrowLeft' ? -far : event.key === 'ArrowRight' ? far : 0;
    const down = event.key === 'ArrowUp' ? -far : event.key === 'ArrowDown' ? far : 0;
    if (down !== 0 || across !== 0) {
      event.preventDefault();
      const within = (cell: number, side: Side) => Math.min(side.cells - 1, Math.max(0, cell));
      look.pick(within((state.row ?? 0) + down, look.down), within((state.column ?? 0) + across, look.across));
      return;
    }
    const about = state.column === null ? (state.across.low + state.across.high) / 2 : look.across.placeOf(state.column);
    if (event.key === '+') zoomBy(0.5, about, 0, false);
    else if (event.key === '-') zoomBy(2, about, 0, false);
    else if (event.key === '0') reset();
  };
  return () => {
    canvas.onkeydown = null;
  };
}

function legend(look: HeatLook): HTMLElement {
  const table = tableOf(look);
  const bar = h('canvas', { width: table.length, height: 1, class: 'heat-legend', 'aria-hidden': 'true' });
  const context = bar.getContext('2d')!;
  table.forEach((colour, k) => {
    context.fillStyle = cssColour(colour);
    context.fillRect(k, 0, 1, 1);
  });
  const { low, high } = look.range;
  const digits = high - low > 20 ? 0 : 2;
  const text = (value: number) => `${look.colours === 'diverging' && value > 0 ? '+' : ''}${value.toFixed(digits).replace('-', '−')} ${look.unit}`;
  return h('div', { class: 'row small number' }, h('span', null, text(low)), bar, h('span', null, text(high)), h('span', { class: 'row' }, h('span', { class: 'no-return', 'aria-hidden': 'true' }), tCharts('no_return')));
}
