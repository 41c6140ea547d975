// A recorded scan again: sensor map over time, playing, bytes, faults, fits.
import { getBinary, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { linkButton, tabs } from '../../core/ui';
import { heatView, indexSide, type Side } from '../../charts/heat_view';
import { timedSpans } from '../../charts/heat_map';
import { angleOfSensor, sensorCount } from '../../charts/polar';
import { ringView } from '../../charts/ring_view';
import { type Range, robustRange } from '../../charts/scale';
import { nearestLevel } from '../../charts/timeline';
import { t } from '../../words/developer';
import { card, Ends, loadInto, quantity, terms } from '../technician/page_parts';
import { BytesPanel } from './bytes_panel';
import { FaultsPanel } from './faults_panel';
import { FitsPanel } from './fits_panel';
import { playerBar } from './player_bar';
import { type OpenReplay, secondsOf, wholeTime } from './replay_file';
import { holdOf, rangesOf, readReplayMap, type ReplayMap, sensorsDown } from './replay_map';
import { timeStrip } from './time_strip';
import '../technician/technician.css';
import './developer.css';

interface Opened {
  replay: OpenReplay;
  map: ReplayMap;
}

export const replayPage = {
  mount(root: HTMLElement, parameters: Record<string, string>): () => void {
    const ends = new Ends();
    const scan = parameters['scan'] ?? '';
    const body = h('div', { class: 'stack' });
    let left = false;
    replace(root, h('div', { class: 'row spread' }, h('h1', null, t('replay_title', { scan })), linkButton(t('other_recording'), '/developer')), body);
    void loadInto(
      body,
      () => open(scan),
      (opened) => {
        const close = () => void post(`/api/replay/${opened.replay.replay_id}/close`).catch(() => {});
        if (left) return close();
        ends.add(close);
        new ReplayView(opened, ends).show(body);
      },
    );
    return () => {
      left = true;
      ends.end();
    };
  },
};

async function open(scan: string): Promise<Opened> {
  const replay = await post<OpenReplay>('/api/replay/open', { scan });
  const map = readReplayMap(await (await getBinary(`/api/replay/${replay.replay_id}/map`)).arrayBuffer());
  return { replay, map };
}

/** The page while a recording is open. */
class ReplayView {
  #level = 0;
  #sensor = 45;
  readonly #map;
  readonly #strip;
  readonly #player;
  readonly #ring;
  readonly #facts = h('div', null);
  readonly #bytes;
  #bytesShown = false;

  constructor(
    private readonly opened: Opened,
    private readonly ends: Ends,
  ) {
    const { replay, map } = opened;
    const whole = wholeTime(replay, Math.max(secondsOf(replay, replay.to_ns), map.timesS.at(-1) ?? 0));
    this.#map = heatView({
      label: t('map_label'),
      matrix: sensorsDown(map),
      across: timeSide(map, whole),
      down: indexSide(t('sensor'), map.sensors),
      colours: 'sequential',
      range: robustRange(map.range, 0.98, { least: 10 }),
      unit: 'mm',
      height: 300,
      pick: (sensor, level) => {
        this.#sensor = sensor;
        this.#player.goTo(level);
      },
      windowChanged: (window) => this.#strip.setWindow(window),
    });
    this.#strip = timeStrip(replay, whole, (timeS) => this.#player.goTo(nearestLevel(map.timesS, timeS)));
    this.#player = playerBar(map, (level) => this.#show(level));
    this.#ring = ringView({
      ringRadius: replay.radius_mm,
      pick: (sensor) => {
        this.#sensor = sensor;
        this.#show(this.#level);
      },
    });
    this.#bytes = new BytesPanel(replay);
    for (const part of [this.#map, this.#strip, this.#player, this.#bytes]) ends.add(() => part.dispose());
  }

  show(root: HTMLElement): void {
    const { replay, map } = this.opened;
    const about = h('p', { class: 'muted' }, t('about', { levels: replay.levels, sweeps: replay.sweeps, sensors: replay.sensors, seconds: secondsOf(replay, replay.to_ns).toFixed(1) }));
    const damage = replay.events.filter((event) => event.kind === 'damage').map((event) => h('p', { class: 'note warn' }, `▲ ${event.text}`));
    if (map.levels === 0) return replace(root, about, h('p', { class: 'note warn' }, t('no_levels')));
    const faults = new FaultsPanel(replay, (level, sensor) => this.#goTo(level, sensor), () => this.#level);
    const fits = new FitsPanel(replay);
    this.ends.add(() => faults.dispose());
    this.ends.add(() => fits.dispose());
    const panel = (shown: boolean, content: HTMLElement) => () => {
      this.#bytesShown = shown;
      if (shown) this.#bytes.show(this.#level);
      return content;
    };
    const profile = h('div', { class: 'sensors-layout' }, this.#ring.root, card(t('sensor'), this.#facts));
    const parts = tabs(t('parts'), [
      { label: t('tab_level'), panel: panel(false, profile) },
      { label: t('tab_bytes'), panel: panel(true, this.#bytes.root) },
      { label: t('tab_faults'), panel: panel(false, faults.root) },
      { label: t('tab_fits'), panel: panel(false, fits.root) },
    ]);
    replace(root, about, ...damage, h('section', { class: 'card stack' }, this.#player.root, this.#map.root, this.#strip.root), parts);
    this.#player.goTo(0);
  }

  #goTo(level: number, sensor: number | null): void {
    if (sensor !== null) this.#sensor = sensor;
    this.#player.goTo(level);
  }

  #show(level: number): void {
    const { map, replay } = this.opened;
    this.#level = level;
    this.#map.setCursor(this.#sensor, level);
    this.#strip.setCursor(map.timesS[level] ?? 0);
    const ranges = rangesOf(map, level);
    this.#ring.setRadii(spread(ranges.map((one) => (one === null ? null : replay.radius_mm - one))));
    this.#ring.setPicked(this.#sensor);
    replace(this.#facts, this.#sensorFacts(ranges));
    if (this.#bytesShown) this.#bytes.show(level);
  }

  #sensorFacts(ranges: readonly (number | null)[]): HTMLElement {
    const { map, replay } = this.opened;
    const range = ranges[this.#sensor] ?? null;
    const missing = ranges.filter((one) => one === null).length;
    return terms([
      [t('sensor'), `${this.#sensor} (${angleOfSensor(this.#sensor)}°)`],
      [t('range'), range === null ? t('no_return') : quantity(range, 3, 'mm')],
      [t('radius'), range === null ? '–' : quantity(replay.radius_mm - range, 3, 'mm')],
      [t('height'), quantity(map.zMm[this.#level], 3, 'mm')],
      [t('time'), quantity(map.timesS[this.#level], 6, 's')],
      [t('missing'), t('n_of', { n: missing, of: ranges.length })],
    ]);
  }
}

/** Readings of a ring with fewer sensors at their places among 180. */
function spread(radii: (number | null)[]): (number | null | undefined)[] {
  const step = Math.max(1, Math.round(sensorCount / Math.max(1, radii.length)));
  return Array.from({ length: sensorCount }, (_, sensor) => (sensor % step === 0 ? radii[sensor / step] : undefined));
}

function timeSide(map: ReplayMap, whole: Range): Side {
  const hold = holdOf(map.timesS);
  return {
    whole,
    label: t('time_axis'),
    least: Math.min(whole.high - whole.low, 12 * hold),
    cells: map.levels,
    spans: (window, pixels) => timedSpans(map.timesS, window, pixels, hold),
    cellAt: (value) => nearestLevel(map.timesS, value),
    placeOf: (level) => map.timesS[level] ?? 0,
  };
}
