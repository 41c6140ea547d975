// Axis and safety chain: where the carriage is, moving it by hand, what the lines say.
import { post } from '../../core/api';
import { booth, type BoothStatus } from '../../core/booth';
import { warningWords } from '../../core/booth_said';
import { h, replace } from '../../core/dom';
import { connected, on, tell } from '../../core/live';
import { session } from '../../core/session';
import { button, ownWords } from '../../core/ui';
import { tShell } from '../../words/shell';
import { t } from '../../words/technician';
import { axisPicture } from './axis_picture';
import { holdButton, HoldToRun } from './hold_to_run';
import { interlockPanel } from './interlock';
import { badge, card, Ends, pageOf, terms } from './page_parts';
import './technician.css';

type Direction = 'up' | 'down';

export const axisPage = {
  mount(root: HTMLElement): () => void {
    const view = new AxisPageView();
    view.show(root);
    return () => view.ends.end();
  },
};

class AxisPageView {
  readonly ends = new Ends();
  readonly #picture = axisPicture();
  readonly #facts = h('div', null);
  readonly #causes = h('div', { 'aria-live': 'polite' });
  readonly #jogLine = h('p', { class: 'jog-line', role: 'status' });
  readonly #hold = new HoldToRun<Direction>({
    beat: (direction) => tell({ type: 'jog', direction }),
    allowed: () => connected.value && whyNoJog() === null,
    changed: (direction) => this.#held(direction),
  });
  readonly #up = jogButton('up');
  readonly #down = jogButton('down');
  readonly #home = button(t('home_order'), () => post('/api/booth/home'), { kind: 'primary' });
  #heldSinceMs = 0;
  #refused = '';

  show(root: HTMLElement): void {
    const interlock = interlockPanel();
    this.ends.add(interlock.dispose);
    pageOf(
      root,
      t('axis_title'),
      this.#causes,
      interlock.summary,
      h(
        'div',
        { class: 'axis-layout' },
        card(t('axis'), this.#picture.root),
        h('div', { class: 'stack' }, card(t('state'), this.#facts, h('div', { class: 'row' }, this.#home)), card(t('jog'), h('p', null, t('jog_how')), h('div', { class: 'jog-buttons' }, this.#up, this.#down), this.#jogLine)),
      ),
      interlock.root,
    );
    this.ends.add(holdButton(this.#up, 'up', ['Enter', 'ArrowUp'], this.#hold));
    this.ends.add(holdButton(this.#down, 'down', ['Enter', 'ArrowDown'], this.#hold));
    this.ends.add(connected.watch((yes) => !yes && this.#hold.release()));
    this.ends.add(booth.watch(() => this.#draw()));
    this.ends.add(
      on('error', (message) => {
        const { seen, advice } = (message['error'] ?? {}) as { seen?: string; advice?: string };
        this.#refused = [seen, advice].filter(Boolean).join(' — ');
        this.#drawJog();
      }),
    );
  }

  #held(direction: Direction | null): void {
    this.#heldSinceMs = Date.now();
    this.#refused = '';
    this.#up.classList.toggle('held', direction === 'up');
    this.#down.classList.toggle('held', direction === 'down');
    this.#drawJog();
  }

  #draw(): void {
    const { status, booth: about, connected: there } = booth.value;
    const z = status?.homed && Number.isFinite(status.z_mm) ? status.z_mm : null;
    const moving = this.#hold.direction === 'up' ? 1 : this.#hold.direction === 'down' ? -1 : 0;
    this.#picture.set({ zMin: about?.axis?.z_min_mm ?? null, zMax: about?.axis?.z_max_mm ?? null, z, homed: status?.homed ?? false, moving: status?.state === 'JOG' ? moving : 0 });
    replace(this.#facts, facts(status, there));
    replace(this.#causes, ...causesOf(status));
    this.#home.disabled = status?.state !== 'IDLE';
    this.#drawJog();
  }

  #drawJog(): void {
    const why = whyNoJog();
    // A button that loses the focus or cannot be pressed while it is held would hide the release; only aria says it.
    for (const one of [this.#up, this.#down]) one.setAttribute('aria-disabled', String(why !== null));
    if (this.#hold.direction === null) return replace(this.#jogLine, why ?? (this.#refused || t('jog_ready')));
    const moves = booth.value.status?.state === 'JOG';
    const late = !moves && Date.now() - this.#heldSinceMs > 800;
    const running = t(this.#hold.direction === 'up' ? 'jog_up_now' : 'jog_down_now');
    replace(this.#jogLine, moves ? badge(running, 'warn') : this.#refused || t(late ? 'jog_does_not_move' : 'jog_asked'));
  }
}

/** Null: the carriage may be moved by hand. */
function whyNoJog(): string | null {
  if (!connected.value) return t('jog_no_line');
  if (session.value && !session.value.local) return t('jog_not_local');
  const { connected: there, status } = booth.value;
  if (!there || !status) return t('jog_no_booth');
  if (status.state !== 'IDLE' && status.state !== 'JOG') return t('jog_not_idle', { state: status.state });
  return null;
}

function jogButton(direction: Direction): HTMLButtonElement {
  return h('button', { type: 'button', class: 'button large jog', 'data-direction': direction }, h('span', { 'aria-hidden': 'true' }, direction === 'up' ? '▲' : '▼'), t(direction === 'up' ? 'jog_up' : 'jog_down'));
}

function facts(status: BoothStatus | null, there: boolean): HTMLElement {
  if (!there || !status) return h('p', { class: 'note bad' }, t('jog_no_booth'));
  const tick = (status as unknown as { longest_tick_ns?: number }).longest_tick_ns;
  return terms([
    [t('state'), `${tShell(`state_${status.state}`)} (${status.state})`],
    [t('state_version'), String(status.version)],
    [t('homed'), status.homed ? t('yes') : t('homed_no')],
    [t('height'), status.homed ? `${status.z_mm.toFixed(2)} mm` : t('not_known')],
    [t('busy_with'), status.job ? `${status.job}${status.stage ? `: ${status.stage}` : ''}` : t('nothing')],
    [t('longest_tick'), tick === undefined ? '–' : `${(tick / 1e6).toFixed(1)} ms`],
  ]);
}

function causesOf(status: BoothStatus | null): Node[] {
  if (!status) return [];
  const serviced = status.causes.length > 0 && status.state === 'FAULT';
  const inOurWords = booth.value.plain?.causes ?? [];
  const causes = status.causes.map((cause) => {
    const words = inOurWords.find((one) => one.code === cause.code) ?? cause;
    return h(
      'section',
      { class: 'failure stack' },
      h('h2', null, `${words.text} `, badge(cause.code), cause.role === 'service' ? badge(t('service_only'), 'warn') : null),
      h('p', null, words.advice, ownWords(`${cause.text}: ${cause.advice}`, `${words.text}: ${words.advice}`)),
    );
  });
  const warnings = status.warnings.map((one) => h('p', { class: 'note warn' }, warningWords(one), ownWords(one.text, warningWords(one))));
  return [...causes, serviced ? h('p', { class: 'row' }, button(t('acknowledge'), () => post('/api/booth/acknowledge'), { kind: 'primary' })) : null, ...warnings].filter((one) => one !== null);
}
