// Events and safety lines under the sensor map, on the same time.
import { h, replace, svg } from '../../core/dom';
import { margins } from '../../charts/heat_view';
import { placed, type Range } from '../../charts/scale';
import { clustered, highStretches } from '../../charts/timeline';
import { t } from '../../words/developer';
import { chainLineWords } from '../../words/technician';
import { type OpenReplay, type ReplayEvent, secondsOf } from './replay_file';

const lane = { height: 22, bar: 10 };
const mostLanes = 8;

interface Lane {
  name: string;
  stretches: Range[];
}

type TimedEvent = ReplayEvent & { timeS: number };

export function timeStrip(replay: OpenReplay, whole: Range, seek: (timeS: number) => void) {
  const root = h('div', { class: 'time-strip', role: 'group', 'aria-label': t('events_and_lines') });
  const told = h('p', { class: 'small event-text', role: 'status' }, t('choose_event'));
  const events: TimedEvent[] = replay.events.map((event) => ({ ...event, timeS: secondsOf(replay, event.time_ns) }));
  const { lanes, still } = lanesOf(replay, whole.high);
  let window: Range = { ...whole };
  let cursorS = 0;
  const draw = () => {
    const width = root.clientWidth;
    if (width < 200) return;
    const area: Range = { low: margins.left, high: width - margins.right };
    const height = 30 + lanes.length * lane.height + 6;
    const mark = (group: { x: number; events: TimedEvent[] }) => eventMark(area.low + group.x, group.events, () => {
      told.textContent = group.events.map((one) => `${one.timeS.toFixed(3)} s  ${one.text}`).join(' · ');
      seek(group.events[0]!.timeS);
    });
    const x = placed(cursorS, window, area);
    replace(
      root,
      svg(
        'svg',
        { width, height, viewBox: `0 0 ${width} ${height}` },
        svg('text', { x: area.low - 8, y: 15, class: 'lane-name' }, t('events')),
        svg('line', { x1: area.low, x2: area.high, y1: 15, y2: 15, class: 'base' }),
        lanes.map((one, k) => drawLane(one, 30 + k * lane.height, window, area)),
        clustered(events, window, area.high - area.low, 14).map(mark),
        x >= area.low && x <= area.high ? svg('line', { x1: x, x2: x, y1: 0, y2: height, class: 'cursor' }) : null,
      ),
      told,
      still > 0 ? h('p', { class: 'small muted' }, t('lines_still', { n: still })) : null,
    );
  };
  const sizes = new ResizeObserver(draw);
  sizes.observe(root);
  return {
    root,
    setWindow(now: Range) {
      window = now;
      draw();
    },
    setCursor(timeS: number) {
      cursorS = timeS;
      draw();
    },
    dispose: () => sizes.disconnect(),
  };
}

/** One lane for each line that changes; of the others only how many. */
function lanesOf(replay: OpenReplay, endS: number): { lanes: Lane[]; still: number } {
  const changes = [...replay.safety].sort((a, b) => a.time_ns - b.time_ns);
  const byLine = new Map<string, { timeS: number; level: boolean }[]>();
  for (const change of changes) {
    const list = byLine.get(change.line) ?? [];
    list.push({ timeS: secondsOf(replay, change.time_ns), level: Boolean(change.level) });
    byLine.set(change.line, list);
  }
  // The watchdog's pulses change all the time and say nothing.
  const moving = [...byLine].filter(([line, told]) => line !== 'watchdog' && new Set(told.map((one) => one.level)).size > 1);
  const lanes = moving.slice(0, mostLanes).map(([line, told]) => ({ name: chainLineWords(line)?.name ?? line, stretches: highStretches(told, endS) }));
  return { lanes, still: byLine.size - lanes.length };
}

function drawLane(one: Lane, top: number, window: Range, area: Range): SVGElement {
  const clip = (timeS: number) => Math.min(area.high, Math.max(area.low, placed(timeS, window, area)));
  const middle = top + lane.height / 2;
  const bars = one.stretches
    .map(({ low, high }) => ({ from: clip(low), to: clip(high) }))
    .filter(({ from, to }) => to > from)
    .map(({ from, to }) => svg('rect', { x: from, y: middle - lane.bar / 2, width: to - from, height: lane.bar, class: 'high' }));
  return svg('g', null, svg('line', { x1: area.low, x2: area.high, y1: middle, y2: middle, class: 'base' }), bars, svg('text', { x: area.low - 8, y: middle, class: 'lane-name' }, one.name));
}

function eventMark(x: number, events: readonly TimedEvent[], choose: () => void): SVGElement {
  // Begins with what is seen on it.
  const text = (events.length > 1 ? `${events.length}: ` : '') + events.map((one) => one.text).join(' · ');
  const mark = svg(
    'g',
    { class: events.some((one) => /cause|fault|error|lost/i.test(one.kind + one.text)) ? 'event bad' : 'event', role: 'button', tabindex: 0, 'aria-label': text, transform: `translate(${x} 15)` },
    svg('title', null, text),
    svg('path', { d: 'M0 -10L9 0L0 10L-9 0Z' }),
    events.length > 1 ? svg('text', { y: 0, class: 'count' }, String(events.length)) : null,
  );
  mark.addEventListener('click', choose);
  mark.addEventListener('keydown', (event) => {
    if ((event as KeyboardEvent).key === 'Enter') choose();
  });
  return mark;
}
