// A station with a head in its store: scanned on the simulated booth, imported as two visits, fitted and released.
import { execFile } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { ask, expectEqual, logIn, openProfile, seconds, startConsole, until, withProfile } from './harness.mjs';

const root = resolve(dirname(fileURLToPath(import.meta.url)), '../..');
const program = process.env.ANNULUS_PROGRAM ?? join(root, 'build/release/annulus');

/** A head takes this long to be fitted on a machine that does nothing else. */
const kFit_s = 120;

/** Answers {station, customer, scan, earlier}: ids of the newer and the older visit. */
export async function stationWithHead(browser) {
  const station = await startConsole();
  try {
    const profile = await openProfile(browser, station.url);
    const page = await profile.open();
    await logIn(page, 'operator');
    const customer = await made(page, '/api/customers', { name: 'Ada Example' });
    const text = (await ask(page, 'GET', '/api/consent-text?language=en')).body;
    const consent = await made(page, `/api/customers/${customer.id}/consents`, { purposes: ['measure', 'glasses'], text_version: text.version, language: 'en', agreed: true });
    const scans = [];
    for (const seed of [1, 2]) scans.push(await importScan(page, await recordHead(station.folder, seed), customer.id, consent.id));
    await profile.close();
    return { station, customer: customer.id, scan: scans[1], earlier: scans[0] };
  } catch (error) {
    await station.stop();
    throw error;
  }
}

/** The same head with other noise for every seed: the store takes a recording only once. Answers its bytes. */
async function recordHead(folder, seed) {
  const [config, recording] = ['toml', 'mcap'].map((end) => join(folder, '..', `head${seed}.${end}`));
  writeFileSync(config, `[sim]\nsubject = "head"\nseed = ${seed}\n`);
  await promisify(execFile)(program, ['scan', '--config', config, '--profile', 'head', '--out', recording], { timeout: seconds(180) });
  return readFileSync(recording);
}

async function made(page, path, body) {
  const answer = await ask(page, 'POST', path, body);
  expectEqual(answer.status, 200, `POST ${path}: ${JSON.stringify(answer.body)}`);
  return answer.body;
}

/** The recording as a visit of the customer, with its model, released. Answers the scan's id. */
async function importScan(page, bytes, customer, consent) {
  const job = await page.evaluate(async ([text, where]) => {
    const { csrf } = await (await fetch('/api/session')).json();
    const body = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return (await fetch(where, { method: 'POST', headers: { 'Content-Type': 'application/octet-stream', 'X-CSRF-Token': csrf }, body })).json();
  }, [bytes.toString('base64'), `/api/scans/import?customer_id=${customer}&consent_id=${consent}`]);
  const done = await until('the import is done', async () => {
    const { body } = await ask(page, 'GET', `/api/jobs/${job.id}`);
    if (body.state === 'failed') throw new Error(`the import failed: ${JSON.stringify(body.error)}`);
    return body.state === 'done' ? body : null;
  }, 60);
  const { id } = done.result.scan;
  await until('there is a model', async () => (await ask(page, 'GET', `/api/scans/${id}`)).body.model, kFit_s);
  await made(page, `/api/scans/${id}/release`, {});
  return id;
}

/** An operator's page at `path`, for one test. */
export const withPage = (browser, common, path, look, run) =>
  withProfile(browser, common.station.url, { viewport: { width: 1280, height: 800 }, ...look }, async (profile) => {
    const page = await profile.open();
    await logIn(page, 'operator');
    await page.evaluate((to) => (location.hash = `#${to}`), path);
    await page.locator('.view3d canvas').first().waitFor();
    await run(page, profile);
  });

/** How many pictures a viewer has drawn. */
export function drawn(page, which = 0) {
  return page.locator('.view3d canvas').nth(which).evaluate((canvas) => Number(canvas.dataset.drawn ?? 0));
}
