// The switch of voice and tones.
import { button } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { muted, setMuted } from './prompts';

export function soundSwitch(): { root: HTMLElement; end: () => void } {
  const root = button('', () => setMuted(!muted.value), { kind: 'quiet' });
  const end = muted.watch((yes) => {
    root.textContent = yes ? t('sound_off') : t('sound_on');
    root.setAttribute('aria-pressed', String(!yes));
  });
  return { root, end };
}
