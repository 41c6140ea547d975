// The two orders that make a scan: arm (the booth checks itself), and start once the key at the booth was pressed.
import { post } from '../../core/api';
import { booth, refreshBooth } from '../../core/booth';
import { navigate } from '../../core/router';
import { changeVisit, visit } from './visit';

/**
 * Orders the booth to make ready for the visit's customer and consent, and goes where that is followed.
 * @throws ApiFailure if the order is refused: another session has the booth, the consent was withdrawn, …
 */
export async function armScan(): Promise<void> {
  const { customer, consent, profile } = visit.value;
  if (!customer || !consent) return navigate('/visit/customer');
  changeVisit({ pressesBefore: booth.value.status?.start_presses ?? 0, scan: null });
  try {
    const height = customer.height_mm ? { height_mm: customer.height_mm } : {};
    await post('/api/booth/arm', { customer_id: customer.id, consent_id: consent.id, profile, ...height });
    await refreshBooth();
  } catch (error) {
    changeVisit({ pressesBefore: null });
    throw error;
  }
  navigate('/visit/scan');
}

let startedVersion = -1;

/**
 * Starts what is armed, as soon as the start key has been pressed since. The version makes one scan of it, whoever
 * else sends the same; a second order for a version is never sent from here.
 * @throws ApiFailure 409 if the booth has changed meanwhile.
 */
export async function startIfPressed(): Promise<boolean> {
  const status = booth.value.status;
  const before = visit.value.pressesBefore;
  if (status?.state !== 'ARMED' || before === null || status.start_presses <= before || startedVersion === status.version) return false;
  startedVersion = status.version;
  await post('/api/booth/start', { version: status.version });
  return true;
}
