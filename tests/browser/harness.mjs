// A console with a simulated booth of its own, and a browser that looks at it.
import { spawn } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import { compareWithReference } from './harness_png.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const root = resolve(here, '../..');
const program = process.env.ANNULUS_PROGRAM ?? join(root, 'build/release/annulus');
const web = process.env.ANNULUS_WEB ?? join(root, 'build/release/web');
const browserPath = process.env.ANNULUS_BROWSER ?? '/usr/bin/chromium';
const artefacts = process.env.ANNULUS_ARTEFACTS ?? join(here, 'artefacts');
/** All waits times this: for a machine that does much else. */
const patience = Number(process.env.ANNULUS_PATIENCE ?? 1);

export const seconds = (n) => n * 1000 * patience;

/** The window of the tests: a tablet's. Small, since the processor draws what a graphics card would. */
export const viewport = { width: 1024, height: 768 };

/** Made for the tests; the three accounts of a simulated station. */
export const passwords = {
  operator: 'forty green teapots',
  technician: 'seven brass hinges',
  admin: 'ninety quiet lanterns',
};

/**
 * `annulus serve --simulated` with a folder of its own, on a free port. `options`: more of its arguments.
 * Answers {url, folder, stop()}; fails with what it said if it is not up in a minute.
 */
export async function startConsole(options = []) {
  const folder = mkdtempSync(join(tmpdir(), 'annulus-browser-'));
  const file = join(folder, 'passwords');
  writeFileSync(file, Object.entries(passwords).map(([user, password]) => `${user} ${password}\n`).join(''), { mode: 0o600 });
  const store = join(folder, 'store');
  const child = spawn(program, ['serve', '--simulated', '--port', '0', '--folder', store, '--web', web, '--password-file', file, ...options], { stdio: ['ignore', 'pipe', 'pipe'] });
  const said = [];
  const ended = new Promise((done) => child.once('exit', done).once('error', done));
  const stop = async () => {
    child.kill('SIGTERM');
    const late = setTimeout(() => child.kill('SIGKILL'), seconds(15));
    await ended;
    clearTimeout(late);
    rmSync(folder, { recursive: true, force: true });
  };
  const address = new Promise((found, failed) => {
    const look = (bytes) => {
      said.push(String(bytes));
      const match = /https:\/\/localhost:(\d+)/.exec(said.join(''));
      if (match) found(`https://localhost:${match[1]}`);
    };
    child.stdout.on('data', look);
    child.stderr.on('data', look);
    child.once('error', failed);
    child.once('exit', () => failed(new Error(`annulus serve ended:\n${said.join('')}`)));
    setTimeout(() => failed(new Error(`annulus serve is not up after a minute:\n${said.join('')}`)), seconds(60)).unref();
  });
  try {
    return { url: await address, folder: store, said: () => said.join(''), stop };
  } catch (error) {
    await stop();
    throw error;
  }
}

export async function openBrowser() {
  return chromium.launch({
    executablePath: browserPath,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-background-networking', '--mute-audio', '--disable-dev-shm-usage'],
  });
}

/**
 * A browser's profile of its own (cookies!), which notes requests that would leave the machine and what the page
 * complains of. `look`: of newContext.
 */
export async function openProfile(browser, url, look = {}) {
  const context = await browser.newContext({ viewport, ignoreHTTPSErrors: true, locale: 'en-GB', reducedMotion: 'reduce', colorScheme: 'light', ...look });
  context.setDefaultTimeout(seconds(30));
  const foreign = [];
  const complaints = [];
  context.on('request', (request) => {
    const to = request.url();
    if (![`${url}/`, 'blob:', 'data:'].some((start) => to.startsWith(start))) foreign.push(to);
  });
  context.on('weberror', (error) => complaints.push(String(error.error().stack ?? error.error())));
  context.on('console', (message) => {
    // A refused request is an answer like any other; the page shows it.
    if (message.type() === 'error' && !message.text().includes('Failed to load resource')) complaints.push(message.text());
  });
  const open = async (path = '/') => {
    const page = await context.newPage();
    await page.goto(`${url}/#${path}`);
    return page;
  };
  const close = async () => {
    // A session that gave orders keeps the booth for a minute, as long as nobody logs out. Not by a page: that would
    // begin anew in the midst of it.
    await within(20, 'log out', logOut(context, url)).catch((error) => console.log(`       ${error.message}`));
    await within(20, 'close the browser’s profile', context.close()).catch((error) => console.log(`       ${error.message}`));
  };
  return { context, foreign, complaints, open, close };
}

/** `work`, if it ends within so many seconds. */
function within(patience_s, what, work) {
  const late = new Promise((_, fail) => setTimeout(() => fail(new Error(`waited ${patience_s} s: ${what}`)), seconds(patience_s)).unref());
  return Promise.race([work, late]);
}

async function logOut(context, url) {
  const { csrf } = await (await context.request.get(`${url}/api/session`)).json();
  await context.request.post(`${url}/api/logout`, { data: {}, headers: { 'X-CSRF-Token': csrf, Origin: url } });
}

/**
 * A profile for one test, closed at its end; nothing may have left the machine, and no script may have failed. What a
 * test that failed had on its screens is kept as failed-*.png.
 */
export async function withProfile(browser, url, look, run) {
  const profile = await openProfile(browser, url, look);
  try {
    await run(profile);
    expectEqual(profile.foreign, [], 'requests to other machines');
    expectEqual(profile.complaints, [], 'complaints of the page');
  } catch (error) {
    for (const [k, page] of profile.context.pages().entries()) await picture(page, `failed-${Date.now()}-${k}`).catch(() => {});
    throw error;
  } finally {
    await profile.close();
  }
}

export async function logIn(page, user) {
  await page.getByRole('textbox', { name: /^(Name|ユーザー名)/ }).fill(user);
  await page.locator('input[name=password]').fill(passwords[user]);
  await page.locator('input[name=password]').press('Enter');
  await page.locator('input[autocomplete=current-password]').waitFor({ state: 'detached' });
}

/** A request of the page's own session, as the page would send it. Answers {status, body}. */
export async function ask(page, method, path, body) {
  return page.evaluate(
    async ([how, where, what]) => {
      const { csrf } = await (await fetch('/api/session')).json();
      const headers = how === 'POST' ? { 'Content-Type': 'application/json', 'X-CSRF-Token': csrf } : {};
      const answer = await fetch(where, { method: how, headers, body: how === 'POST' ? JSON.stringify(what ?? {}) : undefined });
      return { status: answer.status, body: await answer.json().catch(() => null) };
    },
    [method, path, body],
  );
}

/** Waits until `look` answers something true; fails with `what` after so many seconds. */
export async function until(what, look, patience_s = 30) {
  const end = Date.now() + seconds(patience_s);
  for (;;) {
    const found = await look();
    if (found) return found;
    if (Date.now() > end) throw new Error(`waited ${patience_s} s: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

const axeSource = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

/** Fails if axe-core finds what is serious or critical on the page as it is. */
export async function checkAccess(page, name) {
  await page.evaluate(axeSource);
  const found = await page.evaluate(async () => (await globalThis.axe.run(document, { resultTypes: ['violations'] })).violations);
  const grave = found.filter((one) => one.impact === 'serious' || one.impact === 'critical');
  const lines = grave.flatMap((one) => one.nodes.slice(0, 3).map((node) => `  ${one.id}: ${node.target.join(' ')}: ${node.failureSummary}`));
  if (lines.length > 0) throw new Error(`axe-core on ${name}:\n${lines.join('\n')}`);
}

/**
 * Keeps a screenshot; with `compare` also fails if it looks otherwise than its reference. `hide`: selectors of what is
 * another each time (dates, ids).
 */
export async function picture(page, name, { compare = false, hide = [] } = {}) {
  mkdirSync(artefacts, { recursive: true });
  const file = join(artefacts, `${name}.png`);
  await page.screenshot({ path: file, mask: hide.map((selector) => page.locator(selector)), maskColor: '#808080', animations: 'disabled' });
  if (compare) compareWithReference(readFileSync(file), join(here, 'references', `${name}.png`), join(artefacts, `${name}-seen.png`));
}

// Tests: each file names its own; run.mjs runs them in order.
export const tests = [];

export function test(name, run) {
  tests.push({ name, run });
}

export function expect(condition, what) {
  if (!condition) throw new Error(`expected: ${what}`);
}

export function expectEqual(seen, wanted, what) {
  const [a, b] = [JSON.stringify(seen), JSON.stringify(wanted)];
  if (a !== b) throw new Error(`${what}: seen ${a}, wanted ${b}`);
}
