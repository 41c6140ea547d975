// The developer: a recording replayed, looked into byte by byte, with faults, and fitted in two ways.
import { ask, checkAccess, expect, expectEqual, logIn, openProfile, picture, startConsole, test, until, withProfile } from './harness.mjs';

const kScan_s = 240;
const kJob_s = 300;

/** A station on which somebody's head has been scanned; its recording is replayed. */
export async function begin(browser) {
  const station = await startConsole();
  try {
    return { ...station, scan: await scanHead(browser, station.url) };
  } catch (error) {
    await station.stop();
    throw error;
  }
}
export const end = (station) => station.stop();

async function said(page, method, path, body) {
  const answer = await ask(page, method, path, body);
  expect(answer.status === 200, `${method} ${path}: ${answer.status} ${JSON.stringify(answer.body)}`);
  return answer.body;
}

/** Customer, consent, home, arm, start; answers the scan's id. */
async function scanHead(browser, url) {
  const profile = await openProfile(browser, url);
  try {
    const page = await profile.open();
    await logIn(page, 'operator');
    const status = async () => (await said(page, 'GET', '/api/booth')).status;
    const customer = await said(page, 'POST', '/api/customers', { name: 'Somebody', contact: '', height_mm: 1750 });
    const { version } = await said(page, 'GET', '/api/consent-text?language=en');
    const consent = await said(page, 'POST', `/api/customers/${customer.id}/consents`, { purposes: ['measure'], text_version: version, language: 'en', agreed: true });
    await until('the booth is idle', async () => (await status())?.state === 'IDLE', 60);
    if (!(await status()).homed) await said(page, 'POST', '/api/booth/home');
    await until('the carriage is at home', async () => (await status()).homed && (await status()).state === 'IDLE', 120);
    await said(page, 'POST', '/api/booth/arm', { customer_id: customer.id, consent_id: consent.id, profile: 'head', height_mm: 1750 });
    const armed = await until('the start key is pressed', async () => {
      const now = await status();
      return now.state === 'ARMED' && now.start_presses > 0 ? now : null;
    }, 60);
    await said(page, 'POST', '/api/booth/start', { version: armed.version });
    const scans = await until('the scan is in the store', async () => {
      const list = (await said(page, 'GET', '/api/scans?limit=5')).scans;
      return list.length > 0 ? list : null;
    }, kScan_s);
    return scans[0].id;
  } finally {
    await profile.close();
  }
}

const withReplay = (browser, station, look, run) =>
  withProfile(browser, station.url, look, async (profile) => {
    const page = await profile.open('/developer');
    await logIn(page, 'technician');
    await page.getByRole('heading', { level: 1, name: 'Replay a recording' }).waitFor();
    await page.getByRole('link', { name: 'Open' }).first().click();
    await page.getByRole('heading', { level: 1, name: `Replay of ${station.scan}` }).waitFor();
    await page.getByRole('button', { name: 'Play', exact: false }).first().waitFor();
    await run(page);
  });

const button = (page, name) => page.getByRole('button', { name });
const levelOf = async (page) => Number(/level (\d+)/.exec(await page.locator('.player-line').textContent())[1]);

test('a recording is played, stepped through and sought in', (browser, station) =>
  withReplay(browser, station, {}, async (page) => {
    await checkAccess(page, 'replay');
    await button(page, 'One level on').click();
    await button(page, 'One level on').click();
    await button(page, 'One level back').click();
    expectEqual(await levelOf(page), 1, 'the level after two steps on and one back');
    await page.getByLabel('Go to a level').fill('40');
    expectEqual(await levelOf(page), 40, 'the level that was sought');
    await button(page, /▶ Play/).click();
    await until('it plays', async () => (await levelOf(page)) > 42, 30);
    await button(page, /Pause/).click();
    const at = await levelOf(page);
    await new Promise((resolve) => setTimeout(resolve, 300));
    expectEqual(await levelOf(page), at, 'the level while it is paused');
    const map = page.getByRole('img', { name: /Ranges of all sensors over time/ });
    await map.press('ArrowRight');
    expectEqual(await levelOf(page), at + 1, 'the level after an arrow key on the map');
    await picture(page, 'developer-replay');
  }));

test('the bytes of a level are there, with their meaning', (browser, station) =>
  withReplay(browser, station, {}, async (page) => {
    await page.getByRole('tab', { name: 'Bytes' }).click();
    const frames = page.getByRole('listbox', { name: 'Frames of the level' });
    await frames.getByRole('option').first().waitFor();
    await page.getByText(/^0000 {2}[0-9a-f]{2} /).waitFor();
    await frames.press('ArrowDown');
    expectEqual(await frames.getByRole('option').nth(1).getAttribute('aria-selected'), 'true', 'the second frame');
    await checkAccess(page, 'bytes');
    await picture(page, 'developer-bytes');
  }));

test('without faults a replay is identical; a board that is unplugged is seen', (browser, station) =>
  withReplay(browser, station, {}, async (page) => {
    await page.getByRole('tab', { name: 'Faults' }).click();
    await button(page, 'Replay without faults').click();
    await page.getByText('Identical to the last bit.').waitFor({ timeout: kJob_s * 1000 });
    await page.getByLabel('From level').fill('20');
    await button(page, 'Add to the plan').click();
    await button(page, 'Replay with these faults').click();
    await page.getByText('It differs:').waitFor({ timeout: kJob_s * 1000 });
    await checkAccess(page, 'faults');
    await picture(page, 'developer-faults');
    await button(page, 'Show where').click();
    expect((await levelOf(page)) >= 20, 'where it differs first is not before the fault');
  }));

test('a plan that cannot be read is told with its line, and not sent', (browser, station) =>
  withReplay(browser, station, {}, async (page) => {
    await page.getByRole('tab', { name: 'Faults' }).click();
    await page.getByLabel('Fault plan (JSON)').fill('{\n  "format": "annulus fault plan",\n  "version": 1,\n  "faults": [ oops ]\n}');
    await button(page, 'Replay with these faults').click();
    await page.getByText(/line 4/).waitFor();
  }));

test('two fits of the recording stand beside each other, and their surfaces are compared', (browser, station) =>
  withReplay(browser, station, {}, async (page) => {
    await page.getByRole('tab', { name: 'Fits' }).click();
    for (const name of ['A', 'B']) {
      await page.getByRole('button', { name: `Fit ${name}`, exact: true }).click();
      await page.getByRole('img', { name: new RegExp(`Residuals of fit ${name}`) }).waitFor({ timeout: kJob_s * 1000 });
    }
    await page.getByRole('rowheader', { name: 'Residuals, RMS, mm' }).waitFor();
    await button(page, 'Compare the two surfaces').click();
    await page.getByRole('heading', { name: 'The two surfaces' }).waitFor();
    await checkAccess(page, 'fits');
    await picture(page, 'developer-fits');
  }));

for (const [name, look, language] of [['dark', { colorScheme: 'dark' }, 'en'], ['Japanese', {}, 'ja']]) {
  test(`the replay can be used by everybody: ${name}`, (browser, station) =>
    withReplay(browser, station, look, async (page) => {
      if (language === 'ja') {
        await button(page, '日本語').click();
        await page.getByRole('heading', { level: 1, name: `${station.scan}のリプレイ` }).waitFor();
      }
      await page.locator('.player-line').waitFor();
      await checkAccess(page, `replay, ${name}`);
      await picture(page, `developer-replay-${name.toLowerCase()}`);
    }));
}
