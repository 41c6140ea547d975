// The frame around every page: log in, STOP, languages, colours, what a page may ask for.
import { ask, checkAccess, expect, expectEqual, logIn, picture, startConsole, test, until, withProfile } from './harness.mjs';

export const begin = () => startConsole();
export const end = (station) => station.stop();

test('the log-in page is there at once, can be used by everybody, and looks as it did', (browser, station) =>
  withProfile(browser, station.url, {}, async ({ open, context }) => {
    const page = await open();
    await page.getByRole('button', { name: /^Log in/ }).waitFor();
    // Once more: the first one has started the browser's own processes.
    await page.close();
    const again = await context.newPage();
    const from = Date.now();
    await again.goto(station.url);
    await again.getByRole('button', { name: /^Log in/ }).waitFor();
    const took_ms = Date.now() - from;
    await checkAccess(again, 'log in');
    await picture(again, 'login-en', { compare: true, hide: ['.booth-state'] });
    await again.getByRole('button', { name: 'Dark colours' }).click();
    await checkAccess(again, 'log in, dark');
    await picture(again, 'login-dark', { compare: true, hide: ['.booth-state'] });
    console.log(`       interactive after ${took_ms} ms [1500]`);
  }));

test('everything is there in Japanese', (browser, station) =>
  withProfile(browser, station.url, {}, async ({ open }) => {
    const page = await open();
    await page.getByRole('button', { name: '日本語' }).click();
    await page.getByRole('heading', { name: '担当者のログイン' }).waitFor();
    await page.getByRole('button', { name: /停止/ }).waitFor();
    expectEqual(await page.evaluate(() => document.documentElement.lang), 'ja', 'language of the document');
    await checkAccess(page, 'log in, Japanese');
    await picture(page, 'login-ja', { compare: true, hide: ['.booth-state'] });
  }));

test('STOP is on every page, says what it is not, and works without a session', (browser, station) =>
  withProfile(browser, station.url, {}, async ({ open }) => {
    const page = await open();
    const stop = page.getByRole('button', { name: /STOP.*not the emergency stop/ });
    await stop.click();
    await page.getByText('STOP was sent to the booth').waitFor();
    const box = await stop.boundingBox();
    expect(box && box.width >= 120 && box.height >= 48, `STOP is large: ${JSON.stringify(box)}`);
  }));

test('a wrong password is refused in words, and the right one lets in', (browser, station) =>
  withProfile(browser, station.url, {}, async ({ open }) => {
    const page = await open();
    await page.locator('input[name=user]').fill('operator');
    await page.locator('input[name=password]').fill('not the password');
    await page.locator('input[name=password]').press('Enter');
    await page.getByRole('alert').filter({ hasText: 'What to do' }).waitFor();
    await checkAccess(page, 'log in refused');
    await logIn(page, 'operator');
    await page.getByRole('button', { name: 'Log out' }).click();
    await page.locator('input[name=password]').waitFor();
  }));

test('each role finds its own pages and is kept out of the others', (browser, station) =>
  withProfile(browser, station.url, {}, async ({ open }) => {
    const page = await open();
    await logIn(page, 'admin');
    await page.getByRole('heading', { level: 1 }).waitFor();
    await page.evaluate(() => (location.hash = '#/visit/customer'));
    await page.getByRole('heading', { name: 'This page is not for your role' }).waitFor();
    await page.evaluate(() => (location.hash = '#/nowhere'));
    await page.getByRole('heading', { name: 'There is no such page' }).waitFor();
  }));

test('the administrator\'s pages can be used by everybody', (browser, station) =>
  withProfile(browser, station.url, {}, async ({ open }) => {
    const page = await open();
    await logIn(page, 'admin');
    for (const [name, heading] of [['users', 'Accounts'], ['retention', 'How long data are kept'], ['backup', 'Backup'], ['audit', 'Record of actions'], ['store', 'Storage']]) {
      await page.evaluate((to) => (location.hash = `#/admin/${to}`), name);
      await page.getByRole('heading', { name: heading, level: 1 }).waitFor();
      await until(`${name} is loaded`, () => page.evaluate(() => document.querySelector('main table, main form, main .note, main .facts, main .button') !== null));
      expectEqual(await page.getByRole('alert').filter({ hasText: 'That did not work' }).count(), 0, `failures on ${name}`);
      await checkAccess(page, `admin ${name}`);
      // The others show times and sizes.
      await picture(page, `admin-${name}`, { compare: ['retention', 'backup'].includes(name), hide: ['.booth-state'] });
    }
  }));

test('the connection lost is said, and the page comes back by itself', (browser, station) =>
  withProfile(browser, station.url, {}, async ({ open, context }) => {
    const page = await open();
    await logIn(page, 'operator');
    await context.setOffline(true);
    // The line stands until it is used; the page's own is cut as a router would.
    await page.evaluate(() => dispatchEvent(new Event('offline')));
    const answer = await ask(page, 'GET', '/api/session').catch(() => ({ status: 0 }));
    expect(answer.status === 0, 'a request fails without a line');
    await context.setOffline(false);
    await until('the station answers again', async () => (await ask(page, 'GET', '/api/session').catch(() => ({ status: 0 }))).status === 200);
  }));
