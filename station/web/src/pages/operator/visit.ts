// One customer's visit, as this browser holds it: in memory only, and gone at its end.
import { get, post } from '../../core/api';
import { on } from '../../core/live';
import { clearToasts } from '../../core/overlay';
import { role, session } from '../../core/session';
import { Signal } from '../../core/signal';
import type { Consent, Customer, CustomerRecord, Scan } from './records';

export interface Visit {
  customer: Customer | null;
  consent: Consent | null;
  profile: string;
  scan: Scan | null;
  /** start_presses of the booth when we ordered it to arm; null: we have not. */
  pressesBefore: number | null;
}

const nobody: Visit = { customer: null, consent: null, profile: 'body', scan: null, pressesBefore: null };

export const visit = new Signal<Visit>(nobody);

export function changeVisit(part: Partial<Visit>): void {
  visit.set({ ...visit.value, ...part });
}

export function dropVisit(): void {
  visit.set(nobody);
}

/** Makes the visit that of a scan's customer, when a scan is opened by its address. */
export async function takeUp(scan: Scan): Promise<void> {
  if (visit.value.customer?.id !== scan.customer_id) {
    const record = await get<CustomerRecord>(`/api/customers/${scan.customer_id}`);
    const consent = record.consents.find((one) => one.id === scan.consent_id && one.withdrawn_ms === null) ?? null;
    changeVisit({ customer: record, consent, profile: scan.profile });
  }
  changeVisit({ scan });
}

/**
 * The end of a visit: the station drops what it had opened and tells all browsers of this session; each then begins
 * anew, which gives back memory and GPU whatever held it.
 */
export async function endVisit(): Promise<void> {
  try {
    await post('/api/visit/end');
  } finally {
    wipe();
  }
}

/** Leaves nothing of the customer on the screen or in memory. */
export function wipe(): void {
  dropVisit();
  clearToasts();
  document.getElementById('main')?.replaceChildren();
  location.replace('#/');
  location.reload();
}

/** Called once: another window of this session may end the visit; and whoever logs out leaves no customer behind. */
export function watchVisit(): void {
  on('screen_wiped', wipe);
  session.watch(() => {
    if (role() !== 'operator') dropVisit();
  });
}
