// Play, pause, step, seek, speed.
import { h } from '../../core/dom';
import { button, choice, newId } from '../../core/ui';
import { nearestLevel, Player } from '../../charts/timeline';
import { t } from '../../words/developer';
import type { ReplayMap } from './replay_map';

const speeds = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 20];

export interface PlayerBar {
  root: HTMLElement;
  /** Goes to a level and stays there. */
  goTo(level: number): void;
  readonly level: number;
  dispose(): void;
}

/** `moved` is told of every new level; `sweepOf` says which sweep and level of it that is. */
export function playerBar(map: ReplayMap, moved: (level: number) => void): PlayerBar {
  const last = map.levels - 1;
  const player = new Player({ low: map.timesS[0] ?? 0, high: map.timesS[last] ?? 0 });
  let level = 0;
  let frame = 0;
  const id = newId('seek');
  const slider = h('input', { id, type: 'range', min: 0, max: last, step: 1, value: '0', class: 'seek' });
  const line = h('output', { class: 'number player-line', for: id });
  const play = button(`▶ ${t('play')}`, () => (player.playing(performance.now()) ? pause() : start()), { kind: 'primary' });
  const speed = choice(t('speed'), 'speed', speeds.map((one) => [String(one), `${one} ×`] as const), '1');

  const show = (now: number) => {
    level = now;
    slider.value = String(now);
    slider.setAttribute('aria-valuetext', t('level_n', { n: now }));
    line.textContent = t('player_line', { n: now, of: last, time: (map.timesS[now] ?? 0).toFixed(3), z: (map.zMm[now] ?? NaN).toFixed(1) });
    moved(now);
  };
  const tick = () => {
    frame = 0;
    const now = performance.now();
    const at = nearestLevel(map.timesS, player.time(now));
    if (at !== level) show(at);
    if (player.playing(now)) frame = requestAnimationFrame(tick);
    else pause();
  };
  const start = () => {
    player.play(performance.now());
    play.textContent = `❚❚ ${t('pause')}`;
    if (frame === 0) frame = requestAnimationFrame(tick);
  };
  const pause = () => {
    player.pause(performance.now());
    play.textContent = `▶ ${t('play')}`;
    cancelAnimationFrame(frame);
    frame = 0;
  };
  const goTo = (to: number) => {
    const now = Math.min(last, Math.max(0, to));
    player.seek(map.timesS[now] ?? 0, performance.now());
    show(now);
  };
  const step = (by: number) => {
    pause();
    goTo(level + by);
  };
  slider.addEventListener('input', () => goTo(slider.valueAsNumber));
  speed.input.addEventListener('change', () => player.setSpeed(Number(speed.input.value), performance.now()));
  const buttons = [button('|◀', () => step(-last), { label: t('to_start') }), button('◀', () => step(-1), { label: t('step_back') }), play, button('▶|', () => step(1), { label: t('step_on') })];
  const root = h('div', { class: 'player', role: 'group', 'aria-label': t('player') }, h('div', { class: 'row' }, buttons, speed.root, line), h('label', { class: 'hidden-text', for: id }, t('seek')), slider);
  return {
    root,
    goTo,
    get level() {
      return level;
    },
    dispose: pause,
  };
}
