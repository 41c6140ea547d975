// The safety chain as the program sees it, in words.
import { get } from '../../core/api';
import { booth } from '../../core/booth';
import { chainFaultWords } from '../../core/booth_said';
import { h, replace } from '../../core/dom';
import { connected } from '../../core/live';
import { chainLineWords, t } from '../../words/technician';
import { badge, card, Ends } from './page_parts';

interface InterlockLine {
  name: string;
  level: boolean | null;
  direction: 'in' | 'out';
  meaning: string;
  /** An input that opens the chain. */
  stops: boolean;
}

interface ChainFault {
  fault: string;
  present: boolean;
  text: string;
  advice: string;
}

interface Interlock {
  lines: InterlockLine[];
  chain: ChainFault[];
  held_by: string;
  chain_closed: boolean;
}

const askEveryMs = 1000;

/** The chain in a line or two, and all its lines; asks every second while it is shown, and whenever the booth's state changes. */
export function interlockPanel(): { summary: HTMLElement; root: HTMLElement; dispose(): void } {
  const ends = new Ends();
  const chain = h('div', { class: 'stack', 'aria-live': 'polite' });
  const lines = h('div', { class: 'interlock-lines' });
  let drawn = '';
  let asking = false;
  const ask = async () => {
    if (asking || !connected.value) return;
    asking = true;
    try {
      const now = await get<Interlock>('/api/technician/interlock');
      const key = JSON.stringify(now);
      if (key === drawn) return;
      drawn = key;
      replace(chain, ...chainOf(now));
      replace(lines, ...linesOf(now.lines));
    } catch {
      if (drawn === '') replace(lines, h('p', { class: 'muted' }, t('interlock_unknown')));
    } finally {
      asking = false;
    }
  };
  const timer = setInterval(() => void ask(), askEveryMs);
  ends.add(() => clearInterval(timer));
  let state = '';
  ends.add(
    booth.watch((view) => {
      if (view.status?.state === state) return;
      state = view.status?.state ?? '';
      void ask();
    }),
  );
  void ask();
  return { summary: chain, root: card(t('interlock'), lines), dispose: () => ends.end() };
}

function chainOf(now: Interlock): Node[] {
  const faults = now.chain.filter((one) => one.present);
  const held = now.held_by ? [h('p', { class: 'note bad' }, h('strong', null, t('chain_holds')), ' ', now.held_by)] : [];
  if (faults.length === 0 && held.length === 0 && now.chain_closed) return [h('p', { class: 'note good' }, `✓ ${t('chain_closed')}`)];
  const open = now.chain_closed ? [] : [h('p', { class: 'note bad' }, h('strong', null, `▲ ${t('chain_open')}`))];
  return [...open, ...held, ...faults.map(faultOf)];
}

function faultOf(one: ChainFault): HTMLElement {
  const words = chainFaultWords(one.fault, one);
  return h('p', { class: 'note bad' }, h('strong', null, `▲ ${words.text}`), h('br'), words.advice);
}

function linesOf(all: readonly InterlockLine[]): Node[] {
  const list = (title: string, some: InterlockLine[]) => (some.length === 0 ? [] : [h('h3', null, title), h('ul', { class: 'lines' }, some.map(lineOf))]);
  return [...list(t('inputs'), all.filter((one) => one.direction === 'in')), ...list(t('outputs'), all.filter((one) => one.direction === 'out'))];
}

/** What a line is, what it says now, and whether that keeps the booth from moving. */
function lineOf(line: InterlockLine): HTMLElement {
  const known = chainLineWords(line.name);
  const level = line.level === null ? badge(t('level_unknown'), 'warn') : badge(line.level ? '1' : '0');
  const says = line.level === null ? t('level_unknown') : known ? (line.level ? known.high : known.low) : line.meaning;
  const stops = line.level === false && (line.stops || known?.stopsAt === false);
  return h('li', null, level, h('span', null, h('strong', null, known?.name ?? line.name), h('span', { class: stops ? 'bad-text' : '' }, `${stops ? '▲ ' : ''}${says}`)));
}
