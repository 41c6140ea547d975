// The operator's flow on the simulated booth: from "new visit" to the wiped screen; and what may go wrong in it.
import { loadavg } from 'node:os';
import { ask, checkAccess, expect, expectEqual, logIn, picture, startConsole, test, until, withProfile } from './harness.mjs';

/** A scan of the whole body on the simulated booth, and its fit. */
const kScan_s = 180;
const kFit_s = 300;

const english = {
  begin: 'New visit', newCustomer: 'New customer', name: 'Name', height: 'Height (cm)', save: 'Save and go on', agreed: 'The customer has read this and agrees', sign: 'Confirm the consent',
  home: 'Home', next: 'Next', still: 'The customer stands still', skip: 'Go on at once', key: 'Press the start key at the booth', measurements: 'To the measurements',
  show: /The customer agrees: show/, handOver: 'Hand over', done: 'Done: wipe the screen', welcome: 'Welcome', prepare: 'Prepare the scan', head: 'Head',
};
const japanese = {
  begin: '測定を始める', newCustomer: '初めての方', name: 'お名前', height: '身長（cm）', save: '登録して次へ', agreed: 'お客様はこの内容をお読みになり、同意されました', sign: '同意を確認する',
  home: '原点に戻す', next: '次へ', still: 'お客様は動かずに立っています', skip: 'すぐに進む', key: 'ブースのスタートボタンを押してください', measurements: '寸法を見る',
  show: /了承済み/, handOver: 'お渡しへ', done: '完了（画面を消去）', welcome: 'いらっしゃいませ', prepare: '測定の準備', head: '頭部',
};

export const begin = () => startConsole();
export const end = (station) => station.stop();

const withOperator = (browser, station, look, run) =>
  withProfile(browser, station.url, look, async (profile) => {
    await profile.context.addInitScript(noteLevels);
    const page = await profile.open();
    await logIn(page, 'operator');
    await run(page, profile);
  });

/** In the page, before its scripts: notes when each level arrives, as [recorded, sent, arrived], all in ms. */
function noteLevels() {
  globalThis.arrivals = [];
  globalThis.WebSocket = class extends WebSocket {
    constructor(...line) {
      super(...line);
      this.addEventListener('message', ({ data }) => {
        const arrived = Date.now();
        if (!data.startsWith('{"type":"level"')) return;
        const level = JSON.parse(data);
        globalThis.arrivals.push([level.time_ns / 1e6, level.sent_ms, arrived]);
      });
    }
  };
}

/**
 * Says how late levels were in the page. The booth's clock has another zero than the page's: what is recorded is
 * compared with the quickest level of the scan, so that what all have in common is not in
 * it; what the console sent is compared directly. Time that the simulated booth lost on a busy machine counts as late.
 */
async function sayDelays(page) {
  const arrivals = await page.evaluate(() => globalThis.arrivals);
  const quickest = Math.min(...arrivals.map(([recorded, , arrived]) => arrived - recorded));
  const say = (what, delays) => {
    const sorted = delays.sort((a, b) => a - b);
    const at = (share) => Math.round(sorted[Math.floor(share * (sorted.length - 1))]);
    console.log(`       ${what}: p50 ${at(0.5)}, p99 ${at(0.99)}, worst ${at(1)} ms of ${sorted.length} levels, load ${loadavg()[0].toFixed(1)} [p99 100]`);
  };
  say('level recorded … in the page, beyond the quickest', arrivals.map(([recorded, , arrived]) => arrived - recorded - quickest));
  say('level sent by the console … in the page', arrivals.map(([, sent, arrived]) => arrived - sent));
}

const button = (page, name) => page.getByRole('button', { name, exact: typeof name === 'string' });
const stateOf = async (page) => (await ask(page, 'GET', '/api/booth')).body;

/** From the start screen to a signed consent, all of it new. Answers the customer's name. */
async function toChecks(page, t, name) {
  await button(page, t.begin).click();
  await page.getByRole('tab', { name: t.newCustomer }).click();
  await page.getByLabel(t.name, { exact: true }).fill(name);
  await page.getByLabel(t.height).fill('172');
  await checkAccess(page, 'new customer');
  await button(page, t.save).click();
  await page.locator('.consent-text').waitFor();
  await checkAccess(page, 'consent');
  await page.getByLabel(t.agreed).check();
  await button(page, t.sign).click();
  await page.locator('.checks li').first().waitFor();
}

/** The booth found its home, the profile is chosen, the customer stands: until the booth waits for its key. */
async function toKey(page, t, profile) {
  await until('the booth is idle', async () => (await stateOf(page)).status?.state === 'IDLE', 60);
  if (profile) await page.getByRole('radio', { name: profile }).check();
  if (!(await stateOf(page)).status.homed) {
    await button(page, t.home).click();
    await until('the ring has found its home', async () => (await stateOf(page)).status.homed, 60);
  }
  await checkAccess(page, 'booth checks');
  await button(page, t.next).click();
  await page.locator('.stand-drawing').waitFor();
  await checkAccess(page, 'stand');
  await button(page, t.still).click();
  await page.locator('.countdown').waitFor();
  await button(page, t.skip).click();
}

for (const [language, t, locale] of [['en', english, 'en-GB'], ['ja', japanese, 'ja-JP']]) {
  test(`a visit goes from the first screen to the wiped one (${language})`, (browser, station) =>
    withOperator(browser, station, { locale }, async (page) => {
      if (language === 'ja') await button(page, '日本語').click();
      await page.getByRole('heading', { name: t.welcome }).waitFor();
      await checkAccess(page, 'start');
      await picture(page, `start-${language}`);
      await toChecks(page, t, language === 'ja' ? '青木 花子' : 'Ada Example');
      await picture(page, `checks-${language}`);
      await toKey(page, t, t.head);
      // The simulated operator presses the key.
      await page.locator('.growth').waitFor({ timeout: kScan_s * 1000 });
      // The first hundred lie above the head.
      await until('levels come', async () => Number(await page.locator('.facts dd').first().textContent()) > 150, kScan_s);
      await page.locator('.growth canvas[data-drawn]').waitFor();
      await picture(page, `growth-${language}`);
      await checkAccess(page, 'growing body');
      await page.locator('.verdict').waitFor({ timeout: kScan_s * 1000 });
      await checkAccess(page, 'verdict');
      await picture(page, `verdict-${language}`);
      const on = page.getByRole('link', { name: t.measurements });
      await on.waitFor({ timeout: kFit_s * 1000 });
      await on.click();
      await page.locator('.measures table').waitFor({ timeout: kFit_s * 1000 });
      expect((await page.locator('.body-stage').count()) === 0, 'the body is hidden until it is released');
      await button(page, t.show).click();
      await page.locator('.body-stage canvas').waitFor();
      expect((await page.locator('.measures tbody tr').count()) > 10, 'there are measurements');
      await checkAccess(page, 'measurements');
      await picture(page, `measurements-${language}`);
      await page.getByRole('link', { name: t.handOver, exact: true }).click();
      await button(page, t.done).waitFor();
      const saved = page.waitForEvent('download');
      await page.locator('.lines .button.primary').click();
      expect((await saved).suggestedFilename().endsWith('.pdf'), 'the sheet is a PDF');
      await checkAccess(page, 'hand over');
      await picture(page, `hand-over-${language}`, { compare: true, hide: ['.booth-state'] });
      const scanAddress = await page.evaluate(() => location.hash);
      await button(page, t.done).click();
      await page.getByRole('heading', { name: t.welcome }).waitFor();
      expect(!(await page.locator('body').innerText()).match(/Ada Example|青木/), `nothing of the customer is on the screen after ${scanAddress}`);
    }));
}

test('levels are in the page while they are fresh', (browser, station) =>
  withOperator(browser, station, {}, async (page) => {
    await toChecks(page, english, 'Al Fresh');
    await toKey(page, english, english.head);
    // Nothing else is asked of the page until the scan is over: an accessibility check alone stops it for a second.
    await page.locator('.verdict').waitFor({ timeout: 2 * kScan_s * 1000 });
    await sayDelays(page);
  }));

test('STOP in the middle of a scan ends it, says so, and the scan can be repeated', (browser, station) =>
  withOperator(browser, station, {}, async (page) => {
    await toChecks(page, english, 'Bo Stopped');
    await toKey(page, english, english.head);
    await page.locator('.growth').waitFor({ timeout: kScan_s * 1000 });
    await until('levels come', async () => Number(await page.locator('.facts dd').first().textContent()) > 3, kScan_s);
    await page.keyboard.press('Escape');
    await until('the booth stands still', async () => ['IDLE', 'SAFE'].includes((await stateOf(page)).status.state), 30);
    await until('the page says what became of it', async () => (await page.locator('.failure, .verdict').count()) > 0, 60);
    await picture(page, 'stopped');
    await checkAccess(page, 'stopped');
    expect((await button(page, english.prepare).count()) + (await button(page, 'Scan again').count()) > 0, 'there is a way to repeat');
  }));

test('of two windows that start the same scan one is obeyed', (browser, station) =>
  withOperator(browser, station, {}, async (page, profile) => {
    const other = await profile.open('/visit');
    await other.getByRole('heading', { name: english.welcome }).waitFor();
    const customer = (await ask(page, 'POST', '/api/customers', { name: 'Cy Race' })).body;
    const text = (await ask(page, 'GET', '/api/consent-text?language=en')).body;
    const consent = (await ask(page, 'POST', `/api/customers/${customer.id}/consents`, { purposes: ['measure'], text_version: text.version, language: 'en', agreed: true })).body;
    await until('the booth is idle', async () => (await stateOf(page)).status?.state === 'IDLE', 60);
    if (!(await stateOf(page)).status.homed) {
      await ask(page, 'POST', '/api/booth/home');
      await until('the ring has found its home', async () => (await stateOf(page)).status.homed && (await stateOf(page)).status.state === 'IDLE', 60);
    }
    const before = (await stateOf(page)).status.start_presses;
    const armed = await ask(page, 'POST', '/api/booth/arm', { customer_id: customer.id, consent_id: consent.id, profile: 'head', height_mm: 1700 });
    expectEqual(armed.status, 200, `the order to arm: ${JSON.stringify(armed.body)}`);
    const ready = await until('the start key was pressed', async () => {
      const { status } = await stateOf(page);
      return status.state === 'ARMED' && status.start_presses > before ? status : null;
    }, 60);
    const answers = await Promise.all([page, other].map((one) => ask(one, 'POST', '/api/booth/start', { version: ready.version })));
    expectEqual(answers.map((answer) => answer.status).sort(), [200, 409], 'the two answers');
    await ask(page, 'POST', '/api/booth/cancel');
    await until('the booth stands still', async () => (await stateOf(page)).status.state === 'IDLE', 60);
  }));

test('the way to the start key can be gone with the keyboard alone', (browser, station) =>
  withOperator(browser, station, {}, async (page) => {
    const to = async (what, name, key = 'Enter') => {
      await until(`Tab reaches ${name}`, async () => {
        await page.keyboard.press('Tab');
        return page.evaluate(([kind, text]) => {
          const here = document.activeElement;
          const label = here?.getAttribute('aria-label') ?? here?.labels?.[0]?.textContent ?? here?.textContent ?? '';
          return here?.matches(kind) === true && label.includes(text) && getComputedStyle(here).outlineStyle !== 'none';
        }, [what, name]);
      }, 60);
      if (key) await page.keyboard.press(key);
    };
    await page.getByRole('heading', { name: english.welcome }).waitFor();
    await to('button', english.begin);
    await page.getByRole('tab').first().waitFor();
    await to('[role=tab]', 'Been here before', 'ArrowRight');
    await to('input', english.name, null);
    await page.keyboard.type('Di Keys');
    await page.keyboard.press('Enter');
    await page.locator('.consent-text').waitFor();
    await to('input', english.agreed, ' ');
    await to('button', english.sign);
    await page.locator('.checks li').first().waitFor();
    await until('the booth is idle', async () => (await stateOf(page)).status?.state === 'IDLE', 60);
    if (!(await stateOf(page)).status.homed) {
      await to('button', english.home);
      await until('the ring has found its home', async () => (await stateOf(page)).status.homed, 60);
    }
    await to('button', english.next);
    await page.locator('.stand-drawing').waitFor();
    await to('button', english.still);
    await page.locator('.countdown').waitFor();
    await to('button', english.skip);
    await until('the booth was made ready', async () => ['ARMED', 'SCANNING'].includes((await stateOf(page)).status.state), 60);
    await page.keyboard.press('Escape');
    await until('the booth stands still', async () => (await stateOf(page)).status.state === 'IDLE', 60);
  }));

test('a session that ended shows nothing of the customer', (browser, station) =>
  withOperator(browser, station, {}, async (page) => {
    await toChecks(page, english, 'Ed Ended');
    // The page begins anew as soon as the station tells it, which may be before the answer is here.
    await ask(page, 'POST', '/api/logout').catch(() => {});
    // The station tells the page, or the next thing that the page asks does.
    await page.evaluate(() => (location.hash = '#/visit/customer')).catch(() => {});
    await page.locator('input[name=password]').waitFor();
    expect(!(await page.locator('body').innerText()).includes('Ed Ended'), 'the name is gone');
  }));
