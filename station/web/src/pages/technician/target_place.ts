// Where a target is to stand, in words.
import { t } from '../../words/technician';

/** `picture` of a step (docs/console_api.md §11). */
export interface TargetPlace {
  kind: 'cylinder' | 'sphere' | 'plane' | 'step' | string;
  radius_mm: number;
  height_mm?: number | null;
  x_mm: number;
  y_mm: number;
  tilt_deg: number;
  tilt_to_deg: number;
  turn_deg: number | null;
  verify: boolean;
}

/** "110 mm to the left of the middle; its top leans by 7° to the front; its mark points to 60°" */
export function placementText(place: TargetPlace): string {
  const parts = [place.kind === 'plane' || !(place.radius_mm > 0) ? t('target_kind', { kind: kindText(place.kind) }) : t('target_round', { kind: kindText(place.kind), radius: place.radius_mm })];
  const aside = [
    Math.abs(place.x_mm) < 1 ? '' : t(place.x_mm > 0 ? 'mm_right' : 'mm_left', { n: Math.abs(place.x_mm).toFixed(0) }),
    Math.abs(place.y_mm) < 1 ? '' : t(place.y_mm > 0 ? 'mm_front' : 'mm_back', { n: Math.abs(place.y_mm).toFixed(0) }),
  ].filter((part) => part !== '');
  parts.push(aside.length === 0 ? t('in_the_middle') : aside.join(t('and')));
  if (place.kind !== 'plane') parts.push(place.tilt_deg > 0 ? t('leans', { deg: place.tilt_deg.toFixed(0), to: directionText(place.tilt_to_deg) }) : t('upright'));
  if (place.turn_deg !== null) parts.push(t('mark_points', { deg: place.turn_deg.toFixed(0) }));
  return parts.join(t('separator'));
}

/** What a target's description says of it: "cylinder:radius_mm=150,u_mm=0.02". */
export function targetName(spec: string): string {
  const [kind = '', values = ''] = spec.split(':');
  const of = new Map(values.split(',').map((one) => one.split('=') as [string, string]));
  const serial = of.get('serial');
  const name = of.has('radius_mm') ? t('target_name_round', { kind: kindText(kind), radius: of.get('radius_mm')!, u: of.get('u_mm') ?? '–' }) : kindText(kind);
  return serial ? `${name} (${serial})` : name;
}

/** Of several with " + " between them; "verify:" before one that only verifies. */
export function targetsName(specs: string): string {
  const one = (spec: string) => (spec.startsWith('verify:') ? `${t('verifies')}: ${targetName(spec.slice('verify:'.length))}` : targetName(spec));
  return specs.split(' + ').map(one).join(' + ');
}

function kindText(kind: string): string {
  if (kind === 'cylinder') return t('kind_cylinder');
  if (kind === 'sphere') return t('kind_sphere');
  if (kind === 'plane') return t('kind_plane');
  if (kind === 'step') return t('kind_step');
  return kind;
}

/** The nearest of eight directions of the subject, with the angle. */
export function directionText(thetaDeg: number): string {
  const names = ['to_right', 'to_front_right', 'to_front', 'to_front_left', 'to_left', 'to_back_left', 'to_back', 'to_back_right'] as const;
  const theta = ((thetaDeg % 360) + 360) % 360;
  return `${t(names[Math.round(theta / 45) % 8]!)} (${theta.toFixed(0)}°)`;
}
