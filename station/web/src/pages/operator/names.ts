// Names of profiles and verdicts.
import { tOperator as t } from '../../words/operator';
import type { Verdict } from './records';

const profiles = { body: 'profile_body', torso: 'profile_torso', head: 'profile_head', breath: 'profile_breath' } as const;
const explained = { body: 'profile_body_for', torso: 'profile_torso_for', head: 'profile_head_for', breath: 'profile_breath_for' } as const;
const verdicts = { good: 'verdict_good', usable: 'verdict_usable', repeat: 'verdict_repeat', '': 'verdict_none' } as const;

/** Those that measure people; the others are for calibration. */
export const customerProfiles = Object.keys(profiles) as (keyof typeof profiles)[];

export function profileName(profile: string): string {
  return profile in profiles ? t(profiles[profile as keyof typeof profiles]) : profile;
}

export function profileUse(profile: string): string {
  return profile in explained ? t(explained[profile as keyof typeof explained]) : '';
}

export function verdictName(verdict: Verdict): string {
  return t(verdicts[verdict]);
}
