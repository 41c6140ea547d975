// Step 5: the start key, and the body growing while the ring moves.
import { ApiFailure, post, type ErrorText } from '../../core/api';
import { booth, refreshBooth, type BoothStatus, type BoothView } from '../../core/booth';
import { checkWords } from '../../core/booth_said';
import { h, replace } from '../../core/dom';
import { on, tell } from '../../core/live';
import type { Page } from '../../core/page';
import { navigate } from '../../core/router';
import { button, failurePanel, ownWords, showFailure } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { countdown } from './countdown';
import { growth } from './growth';
import { isFault } from './fault_panel';
import { armScan, startIfPressed } from './order_scan';
import { say, silence, tone } from './prompts';
import type { Scan } from './records';
import { soundSwitch } from './sound_switch';
import { stepFrame, type StepFrame } from './step_frame';
import { changeVisit, visit } from './visit';

/** The booth waits so long for its start key (docs/operator.md). */
const kArmed_s = 60;

type Check = NonNullable<BoothStatus['arm']>['checks'][number];
type Phase = 'checking' | 'failed' | 'armed' | 'moving' | 'storing' | 'idle';

export const scanPage: Page = {
  path: '/visit/scan',
  roles: ['operator'],
  title: null,
  mount(root) {
    const frame = stepFrame(root, { step: 'step_scan', title: t('scan_title'), back: '/visit/stand' });
    const steps = new ScanSteps(frame);
    const sound = soundSwitch();
    replace(frame.tools, sound.root);
    const ends = [booth.watch((view) => steps.follow(view)), on('scan_result', (message) => steps.ended(message as unknown as ScanResultMessage)), frame.end, sound.end];
    tell({ type: 'subscribe', sensor_step: 1 });
    void refreshBooth();
    return () => {
      for (const end of ends) end();
      steps.dispose();
      silence();
    };
  },
};

interface ScanResultMessage {
  customer_id: string;
  scan: Scan | string | null;
  error: ErrorText | null;
}

/** What the page shows, as the booth goes from checking to ready, moving and done. */
class ScanSteps {
  readonly #frame: StepFrame;
  #phase: Phase | null = null;
  #growth: ReturnType<typeof growth> | null = null;
  #timer: { end: () => void } = { end: () => {} };
  #moved = false;
  /** It was said that nothing was kept: that stays on the screen until the next order. */
  #over = false;

  constructor(frame: StepFrame) {
    this.#frame = frame;
  }

  follow(view: BoothView): void {
    if (isFault(view)) {
      // The frame says what is wrong; what has grown so far stays to be seen.
      this.#timer.end();
      if (this.#phase !== 'moving') this.#clear();
      this.#phase = null;
      replace(this.#frame.actions, this.#againButton());
      return;
    }
    const status = view.status;
    if (!status) return;
    const phase = this.#phaseOf(status);
    if (phase === 'armed' || phase === 'checking') this.#over = false;
    if (this.#over) return;
    if (phase !== this.#phase) this.#enter(phase, status);
    if (phase === 'armed') void startIfPressed().catch((error: unknown) => this.#refused(error));
    if (phase === 'moving') this.#growth?.follow(status);
  }

  /** A scan has ended and is kept, or it is said why not. */
  ended(message: ScanResultMessage): void {
    if (!message.scan) {
      tone('trouble');
      this.#clear();
      this.#over = true;
      this.#moved = false;
      this.#phase = 'failed';
      const text = message.error ?? { attempted: t('scan_title'), seen: t('scan_not_kept'), advice: t('scan_again_do') };
      this.#show([failurePanel(new ApiFailure(0, text)), h('p', null, t('scan_failed_text'))], [this.#againButton()]);
      return;
    }
    const scan = message.scan;
    changeVisit({ scan: typeof scan === 'string' ? null : scan, pressesBefore: null });
    navigate(`/scans/${typeof scan === 'string' ? scan : scan.id}`);
  }

  dispose(): void {
    this.#clear();
  }

  #phaseOf(status: BoothStatus): Phase {
    if (status.state === 'ARMED') return 'armed';
    if (status.state === 'SCANNING' || status.state === 'STOPPING') return 'moving';
    if (this.#moved) return 'storing';
    if (status.job === 'arm' || status.state === 'HOMING') return 'checking';
    if (visit.value.pressesBefore !== null && status.arm && !status.arm.passed) return 'failed';
    return 'idle';
  }

  #enter(phase: Phase, status: BoothStatus): void {
    this.#phase = phase;
    this.#timer.end();
    if (phase !== 'moving' && phase !== 'storing') this.#clear();
    if (phase === 'checking') this.#show([h('p', { class: 'lead' }, t('scan_checking'))], []);
    if (phase === 'idle') this.#show([h('p', { class: 'lead' }, t('scan_idle'))], [this.#againButton()]);
    if (phase === 'failed') this.#showFailedChecks(status);
    if (phase === 'armed') this.#showKey();
    if (phase === 'moving') this.#showGrowth();
    if (phase === 'storing') this.#storing();
  }

  #showKey(): void {
    this.#moved = false;
    tone('ready');
    const ring = countdown(t('scan_key_left'), kArmed_s, () => {}, () => {});
    this.#timer = ring;
    this.#show(
      [h('div', { class: 'key-prompt' }, h('div', { class: 'key-picture', 'aria-hidden': 'true' }), h('div', { class: 'stack' }, h('p', { class: 'giant' }, t('scan_key')), h('p', { class: 'lead' }, t('scan_key_where'))), ring.root)],
      [button(t('cancel'), () => post('/api/booth/cancel'), { large: true })],
    );
  }

  #showGrowth(): void {
    this.#moved = true;
    tone('start');
    say(t('say_measuring'));
    this.#growth ??= growth();
    this.#show([this.#growth.root], [button(t('scan_cancel'), () => post('/api/booth/cancel'), { kind: 'danger', large: true })]);
  }

  #storing(): void {
    tone('done');
    say(t('say_done'));
    this.#growth?.finished();
    replace(this.#frame.actions, h('p', { role: 'status' }, t('scan_storing')));
  }

  #showFailedChecks(status: BoothStatus): void {
    const failed = (status.arm?.checks ?? []).filter((check) => check.error !== null);
    tone('trouble');
    this.#show(
      [h('p', { class: 'lead' }, t('scan_checks_failed')), ...failed.map(failedCheck)],
      [this.#againButton()],
    );
  }

  #againButton(): HTMLElement {
    return button(t('scan_arm'), () => ((this.#moved = false), armScan()), { kind: 'primary', large: true });
  }

  #refused(error: unknown): void {
    // Another window was faster: its scan is shown like ours.
    const state = booth.value.status?.state;
    if (error instanceof ApiFailure && error.status === 409 && (state === 'SCANNING' || state === 'STOPPING')) return;
    showFailure(error);
  }

  #show(content: (Node | null)[], actions: Node[]): void {
    replace(this.#frame.content, ...content);
    replace(this.#frame.actions, ...actions);
  }

  #clear(): void {
    this.#timer.end();
    this.#growth?.dispose();
    this.#growth = null;
  }
}

function failedCheck({ name, error }: Check): HTMLElement {
  const words = checkWords(name, { text: error?.seen ?? name, advice: error?.advice ?? '' });
  return h('section', { class: 'failure stack', role: 'alert' }, h('h2', null, words.text), h('p', { class: 'do' }, words.advice, ownWords(error?.seen ?? '', words.text)));
}
