// The technician: jog only while it is held, doctor, a calibration up to its certificate, and pages for everybody.
import { ask, checkAccess, expect, expectEqual, logIn, picture, startConsole, test, until, withProfile } from './harness.mjs';

/** A placement is scanned on a simulated booth of its own; then everything is solved. */
const kPlacement_s = 180;
const kSolve_s = 300;

export const begin = () => startConsole();
export const end = (station) => station.stop();

const withTechnician = (browser, station, look, run) =>
  withProfile(browser, station.url, look, async (profile) => {
    const page = await profile.open();
    await logIn(page, 'technician');
    await run(page, profile);
  });

const button = (page, name) => page.getByRole('button', { name });
const booth = async (page) => (await ask(page, 'GET', '/api/booth')).body.status;
const height = async (page) => (await booth(page)).z_mm;

async function goTo(page, path, heading) {
  await page.evaluate((to) => (location.hash = `#${to}`), path);
  await page.getByRole('heading', { level: 1, name: heading }).waitFor();
}

/** The axis page of a booth that has found its home. */
async function toAxis(page) {
  await goTo(page, '/technician/axis', 'Axis and safety chain');
  await until('the booth is idle', async () => (await booth(page))?.state === 'IDLE', 60);
  if (!(await booth(page)).homed) await button(page, 'Find home').click();
  await until('the carriage is at home', async () => {
    const now = await booth(page);
    return now.homed && now.state === 'IDLE';
  }, 120);
  await page.getByText('Ready. Nothing moves.').waitFor();
}

/** Fails unless the booth is idle within a second, and stays where it is. */
async function expectAtRest(page, what) {
  await until(`${what}: the booth is idle`, async () => (await booth(page)).state === 'IDLE', 5);
  const at = await height(page);
  for (let look = 0; look < 5; look += 1) expect(Math.abs((await height(page)) - at) < 0.5, `${what}: the carriage rests`);
}

/**
 * Begins to hold, and waits until the carriage has moved. A beat that comes late on a busy machine ends a hold, as it
 * must; then it is let go and held anew.
 */
async function hold(page, down, up, what) {
  for (let attempt = 0; attempt < 10; attempt += 1) {
    const from = await height(page);
    await down();
    const moved = await until('it moves', async () => Math.abs((await height(page)) - from) > 3, 3).catch(() => false);
    if (moved) return;
    await up();
    await until('it is at rest', async () => (await booth(page)).state === 'IDLE', 5);
    // The booth takes a key that is pressed again within 300 ms for one that is still held.
    await page.waitForTimeout(400);
  }
  throw new Error(`${what}: the carriage does not move while the button is held`);
}

test('the carriage moves only while a button is held: by pointer and by key', (browser, station) =>
  withTechnician(browser, station, {}, async (page) => {
    await toAxis(page);
    await checkAccess(page, 'axis');
    const down = button(page, 'Hold: down');
    await down.scrollIntoViewIfNeeded();
    const box = await down.boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await hold(page, () => page.mouse.down(), () => page.mouse.up(), 'pointer');
    await page.getByText('moves down').waitFor();
    await page.mouse.up();
    await expectAtRest(page, 'after the release');

    await hold(page, () => page.mouse.down(), () => page.mouse.up(), 'pointer again');
    await page.mouse.move(box.x - 60, box.y - 60);
    await expectAtRest(page, 'after the pointer has left the button');
    await page.mouse.up();

    await button(page, 'Hold: up').focus();
    await hold(page, () => page.keyboard.down('Enter'), () => page.keyboard.up('Enter'), 'key');
    await page.keyboard.up('Enter');
    await expectAtRest(page, 'after the key came up');
    await picture(page, 'technician-axis');
  }));

test('a hold ends when the page is left', (browser, station) =>
  withTechnician(browser, station, {}, async (page) => {
    await toAxis(page);
    await button(page, 'Hold: down').focus();
    await hold(page, () => page.keyboard.down('ArrowDown'), () => page.keyboard.up('ArrowDown'), 'key');
    await page.evaluate(() => (location.hash = '#/technician/doctor'));
    await expectAtRest(page, 'after the page was left');
    await page.keyboard.up('ArrowDown');
  }));

test('the doctor examines the booth and says what it saw', (browser, station) =>
  withTechnician(browser, station, {}, async (page) => {
    await goTo(page, '/technician/doctor', 'Doctor');
    await button(page, 'Examine the booth').click();
    await page.getByRole('table', { name: 'Ring' }).waitFor({ timeout: 120_000 });
    expect((await page.getByRole('row').count()) > 12, 'a row for each of twelve boards');
    await checkAccess(page, 'doctor');
    await picture(page, 'technician-doctor');
  }));

test('a calibration leads step by step to its certificate, and is put in force', (browser, station) =>
  withTechnician(browser, station, {}, async (page) => {
    await goTo(page, '/technician/calibration', 'Calibration of the ring');
    await checkAccess(page, 'calibration, before');
    await button(page, 'Begin').click();
    await page.getByRole('img', { name: /cylinder, radius 150 mm; in the middle; upright/ }).waitFor();
    await checkAccess(page, 'calibration, first step');
    await picture(page, 'technician-calibration-step');
    const run = async () => (await ask(page, 'GET', '/api/calibration')).body.run;
    const steps = (await run()).steps.length;
    for (let step = 0; step < steps; step += 1) {
      await page.getByRole('heading', { name: `Step ${step + 1} of ${steps}` }).waitFor();
      await button(page, /It stands so: scan|Scan it again/).click();
      await until(`step ${step + 1} is taken`, async () => (await run()).steps[step].state === 'taken', kPlacement_s);
    }
    await button(page, 'Solve').click();
    await page.getByRole('heading', { name: 'Result' }).waitFor({ timeout: kSolve_s * 1000 });
    await page.getByText('It keeps all its limits.').waitFor();
    await page.getByText('Certificate', { exact: true }).first().waitFor();
    await checkAccess(page, 'calibration, result');
    await picture(page, 'technician-calibration-result');
    await button(page, 'Put it in force').click();
    await page.getByRole('dialog').getByRole('button', { name: 'Put it in force' }).click();
    await page.getByRole('table', { name: 'Earlier calibrations' }).waitFor();
    expectEqual((await ask(page, 'GET', '/api/calibration')).body.run, null, 'the run after it was accepted');
  }));

test('a mistake in a configuration is shown at its line', (browser, station) =>
  withTechnician(browser, station, {}, async (page) => {
    await goTo(page, '/technician/parameters', 'Parameters');
    const text = page.getByLabel('Configuration (TOML)');
    await text.fill('[station]\nid = "x"\n\n[ring]\nbuss = "usb"\n');
    await button(page, 'Check a text').click();
    await page.getByRole('alert').filter({ hasText: 'line 5' }).waitFor();
    expectEqual(await page.locator('.gutter .bad-line').textContent(), '▲5\n', 'the marked line');
    await text.fill('[station]\nid = "x"\n');
    await button(page, 'Check a text').click();
    await page.getByText('The text is good.').waitFor();
    await page.getByLabel('Find a key or value').fill('radius');
    expectEqual(await page.locator('main tbody tr').count(), 1, 'keys found');
  }));

const kPages = [
  ['sensors', 'Sensors around the ring', 'リングのセンサー'],
  ['axis', 'Axis and safety chain', '昇降軸と安全回路'],
  ['doctor', 'Doctor', '診断'],
  ['calibration', 'Calibration of the ring', 'リングの校正'],
  ['drift', 'Drift of the sensors', 'センサーのドリフト'],
  ['parameters', 'Parameters', 'パラメーター'],
  ['recordings', 'Recordings', '測定記録'],
  ['audit', 'Audit', '監査記録'],
];

for (const [name, look, language] of [['light', {}, 'en'], ['dark', { colorScheme: 'dark' }, 'en'], ['Japanese', {}, 'ja']]) {
  test(`the technician's pages can be used by everybody: ${name}`, (browser, station) =>
    withTechnician(browser, station, look, async (page) => {
      if (language === 'ja') await button(page, '日本語').click();
      for (const [path, english, japanese] of kPages) {
        await goTo(page, `/technician/${path}`, language === 'ja' ? japanese : english);
        await until(`${path} is loaded`, () => page.evaluate(() => !/Loading|読み込み中/.test(document.querySelector('main').textContent)));
        expectEqual(await page.getByRole('alert').filter({ hasText: /That did not work|うまくいきません/ }).count(), 0, `failures on ${path}`);
        await checkAccess(page, `${path}, ${name}`);
        await picture(page, `technician-${path}-${name.toLowerCase()}`, { compare: ['drift', 'parameters'].includes(path), hide: ['.booth-state'] });
      }
    }));
}

test('a sensor is picked by pointer, by key and by its number', (browser, station) =>
  withTechnician(browser, station, {}, async (page) => {
    await goTo(page, '/technician/sensors', 'Sensors around the ring');
    const number = page.getByLabel('Number (0 … 179)');
    const ring = page.getByRole('img', { name: /The ring seen from above/ });
    const box = await ring.boundingBox();
    await ring.click({ position: { x: box.width * 0.85, y: box.height / 2 } });
    expectEqual(await number.inputValue(), '0', 'the sensor on the right');
    await ring.press('ArrowLeft');
    expectEqual(await number.inputValue(), '1', 'the next one, counter-clockwise');
    await number.fill('135');
    await page.getByText('board 10, channel 0').or(page.getByText(/board 10 \(\d+\), channel 0/)).waitFor();
  }));
