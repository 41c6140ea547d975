// The glasses designer on a head of the simulated booth.
import { loadavg } from 'node:os';
import { ask, checkAccess, expect, expectEqual, picture, seconds, test, until } from './harness.mjs';
import { drawn, stationWithHead, withPage } from './measure_head.mjs';

export const begin = (browser) => stationWithHead(browser);
export const end = ({ station }) => station.stop();

const designer = (browser, common, look, run) =>
  withPage(browser, common, `/scans/${common.scan}/glasses`, look, async (page, profile) => {
    await page.locator('.adjusted .badge').waitFor();
    await run(page, profile);
  });

const tab = (page, name) => page.getByRole('tab', { name, exact: true }).click();
const height = (page) => page.locator('input[type=range]').nth(6);
const heightNumber = (page) => page.locator('.slider-number').nth(6);
const previews = (page) => page.evaluate(() => performance.getEntriesByType('resource').filter((entry) => entry.name.includes('/glasses/preview')).length);

/** Presses an arrow on a slider. */
async function nudge(slider, times) {
  await slider.focus();
  for (let i = 0; i < times; ++i) await slider.press('ArrowRight');
}

test('a slider moves the frame on the head; undo and redo go back and forth, by keys too', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    const before = await heightNumber(page).inputValue();
    const asked = await previews(page);
    const pictures = await drawn(page);
    await nudge(height(page), 5);
    const after = await heightNumber(page).inputValue();
    expect(Number(after) > Number(before), `the height grows: ${before}, ${after}`);
    await until('the preview was asked for and drawn', async () => (await previews(page)) > asked && (await drawn(page)) > pictures);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await until('undo brings a former height', async () => Number(await heightNumber(page).inputValue()) < Number(after));
    for (let i = 0; i < 5; ++i) await page.keyboard.press('Control+z');
    await until('all is undone', async () => (await heightNumber(page).inputValue()) === before);
    await page.keyboard.press('Control+y');
    await until('redo goes forth', async () => Number(await heightNumber(page).inputValue()) > Number(before));
  }));

/** In the page: notes when pictures with a new preview have been drawn to the end, from now on. */
function noteFrames() {
  const canvas = document.querySelector('.view3d canvas');
  const gl = canvas.getContext('webgl2');
  const previews = () => performance.getEntriesByType('resource').filter((entry) => entry.name.includes('/glasses/preview')).length;
  performance.setResourceTimingBufferSize(5000);
  let seen = previews();
  globalThis.frames = [];
  new MutationObserver(() => {
    if (previews() === seen) return;
    seen = previews();
    // Reading a pixel back waits until all that was ordered has been drawn.
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    globalThis.frames.push(performance.now());
  }).observe(canvas, { attributes: true, attributeFilter: ['data-drawn'] });
}

test('a slider that is dragged drives the picture in software rendering', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    const canvas = page.locator('.view3d canvas').first();
    const size = async () => canvas.evaluate(({ clientWidth, clientHeight }) => ({ width: clientWidth, height: clientHeight }));
    const before = await size();
    const window = page.viewportSize();
    await page.setViewportSize({ width: window.width + 800 - before.width, height: window.height + 600 - before.height });
    const { width, height: high } = await size();
    await height(page).scrollIntoViewIfNeeded();
    const box = await height(page).boundingBox();
    const y = box.y + box.height / 2;
    await page.mouse.move(box.x + box.width / 2, y);
    await page.mouse.down();
    await page.evaluate(noteFrames);
    for (const from = Date.now(); Date.now() - from < 6000; ) await page.mouse.move(box.x + box.width * (0.5 + 0.45 * Math.sin((Date.now() - from) / 500)), y);
    await page.mouse.up();
    const frames = await page.evaluate(() => globalThis.frames);
    expect(frames.length > 0, 'the picture follows the slider');
    const rates = frames.slice(1).map((at, k) => 1000 / (at - frames[k])).sort((a, b) => a - b);
    const triangles = await canvas.evaluate((element) => element.dataset.triangles);
    expect(Number(triangles) > 0 && Number(triangles) <= 40_000, `triangles: ${triangles}`);
    console.log(`       a dragged slider: p50 ${rates[Math.floor(rates.length / 2)]?.toFixed(1)}, worst ${rates[0]?.toFixed(1)} frames/s of ${frames.length}, ${triangles} triangles at ${width} × ${high}, software rendering, load ${loadavg()[0].toFixed(1)} [5]`);
  }));

test('turning the head is fluent, drawn by the processor', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    const viewer = page.locator('.view3d').first();
    const box = await viewer.boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    const [from, frames] = [Date.now(), await drawn(page)];
    for (let i = 0; Date.now() - from < 4000; ++i) await page.mouse.move(box.x + box.width / 2 + 150 * Math.sin(i / 10), box.y + box.height / 2);
    const rate = ((await drawn(page)) - frames) / ((Date.now() - from) / 1000);
    await page.mouse.up();
    console.log(`       turning: ${rate.toFixed(1)} frames/s at ${Math.round(box.width)} × ${Math.round(box.height)}, software rendering [5]`);
  }));

test('two designs stand side by side, each changed by itself, and turn together', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    const style = page.getByLabel('Style', { exact: true });
    const first = await style.inputValue();
    await page.getByRole('button', { name: 'Two designs' }).click();
    await page.locator('.view3d canvas').nth(1).waitFor();
    await style.selectOption('round');
    await page.getByRole('button', { name: 'Design A', exact: true }).click();
    await until('A keeps its style', async () => (await style.inputValue()) === first);
    await page.getByRole('button', { name: 'Design B', exact: true }).click();
    await until('B has its own', async () => (await style.inputValue()) === 'round');
    const before = [await drawn(page, 0), await drawn(page, 1)];
    await page.locator('.view3d').first().focus();
    await page.keyboard.press('ArrowRight');
    await until('both turned', async () => (await drawn(page, 0)) > before[0] && (await drawn(page, 1)) > before[1]);
    await checkAccess(page, 'two designs');
    await picture(page, 'designer-two');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await until('undo ends the comparison', async () => (await page.locator('.view3d canvas').count()) === 1);
  }));

test('colours are chosen from samples and made more vivid by the station', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    await tab(page, 'Colours');
    await page.getByRole('button', { name: 'green', exact: true }).click();
    const shown = page.locator('.colour-shown').first();
    await until('the colour is described', async () => /#[0-9a-f]{6} · H/.test(await shown.innerText()));
    const before = await shown.innerText();
    await nudge(page.getByRole('slider', { name: 'Vividness' }), 20);
    await until('it has become another', async () => (await shown.innerText()) !== before);
    await page.getByLabel('Lower half as the upper').uncheck();
    await page.getByText('Metal', { exact: true }).click();
    await page.getByText('Tortoiseshell', { exact: true }).click();
    await checkAccess(page, 'colours');
    await picture(page, 'designer-colours');
  }));

test('a prescription is checked before it is used', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    await tab(page, 'Lenses');
    await page.getByLabel('Right Sphere').fill('-40');
    await page.getByLabel('Left Sphere').fill('-3.5');
    await page.getByLabel('Right Cylinder').fill('-0.75');
    await page.getByLabel('Prescriber').fill('Dr. Example');
    await page.getByRole('button', { name: 'Use this prescription' }).click();
    await page.getByText('Right Sphere: must be -30 … 30').waitFor();
    await page.getByText('Right Axis: a cylinder needs an axis').waitFor();
    await checkAccess(page, 'prescription with errors');
    await page.getByLabel('Right Sphere').fill('-4');
    await page.getByLabel('Right Axis').fill('90');
    await page.getByRole('button', { name: 'Use this prescription' }).click();
    await until('the power is the prescription’s', async () => (await page.getByRole('slider', { name: 'Power' }).count()) === 0);
    await picture(page, 'designer-prescription');
  }));

test('the fit is told in words, and its files can be had', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    await tab(page, 'Fit');
    await page.getByRole('button', { name: 'Fit it on and check' }).click();
    await page.getByText(/Score \d+ of 100/).waitFor({ timeout: seconds(90) });
    expect((await page.locator('.designer-side tbody tr').count()) > 10, 'distances and contacts are listed');
    await checkAccess(page, 'fit report');
    await picture(page, 'designer-fit');
    await page.getByRole('button', { name: 'Design (.json)' }).click();
    const link = page.locator('.files a').first();
    await link.waitFor({ timeout: seconds(60) });
    expect((await link.getAttribute('href')).startsWith('/api/artefacts/'), 'the file is an artefact');
  }));

test('the true picture comes coarse at once and gets finer; closing it ends the work', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    await page.getByRole('button', { name: 'True picture' }).click();
    const image = page.locator('.picture-strip img');
    await until('a first picture is there', async () => (await image.getAttribute('src'))?.startsWith('blob:'), 120);
    const first = await image.getAttribute('src');
    await until('another, finer one comes', async () => (await image.getAttribute('src')) !== first, 120);
    await checkAccess(page, 'true picture');
    await picture(page, 'designer-true-picture', { hide: ['.picture-strip figcaption'] });
    await page.getByRole('button', { name: 'Close the picture' }).click();
    await until('the work has ended', async () => {
      const { jobs } = (await ask(page, 'GET', '/api/jobs')).body;
      return jobs.every((job) => !['waiting', 'running'].includes(job.state));
    });
  }));

test('the library is ranked for this head, and a frame of it tried on', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    await tab(page, 'Library');
    await page.getByRole('button', { name: 'Rank all frames' }).click();
    const rows = page.locator('.ranked');
    await rows.first().waitFor({ timeout: seconds(300) });
    const scores = (await rows.locator('p').allInnerTexts()).map((text) => Number(/Score (\d+)/.exec(text)[1]));
    expect(scores.length >= 10, `frames: ${scores.length}`);
    await checkAccess(page, 'library');
    await picture(page, 'designer-library');
    const name = (await rows.nth(1).locator('strong').innerText()).trim();
    await rows.nth(1).getByRole('button').click();
    await tab(page, 'Shape');
    await until('its style is chosen', async () => (await page.getByLabel('Style', { exact: true }).locator('option:checked').innerText()) === name);
  }));

test('designs are saved, loaded and removed', (browser, common) =>
  designer(browser, common, {}, async (page) => {
    await nudge(height(page), 3);
    const kept = await heightNumber(page).inputValue();
    await tab(page, 'Saved');
    await page.getByLabel('Title').fill('Of the browser test');
    await page.getByRole('button', { name: 'Save', exact: true }).click();
    const load = page.getByRole('button', { name: 'Load: Of the browser test' });
    await load.waitFor();
    await checkAccess(page, 'saved designs');
    await tab(page, 'Shape');
    await nudge(height(page), 10);
    await tab(page, 'Saved');
    await load.click();
    await tab(page, 'Shape');
    await until('it is as it was', async () => (await heightNumber(page).inputValue()) === kept);
    await tab(page, 'Saved');
    await page.getByRole('button', { name: 'Remove: Of the browser test' }).click();
    await load.waitFor({ state: 'detached' });
  }));

for (const [language, theme] of [['en', 'light'], ['ja', 'dark']]) {
  test(`everybody can use it on a tablet: ${language}, ${theme}`, (browser, common) =>
    designer(browser, common, { viewport: { width: 1024, height: 768 }, colorScheme: theme }, async (page) => {
      if (language === 'ja') await page.getByRole('button', { name: '日本語' }).click();
      await page.locator('.adjusted .badge').waitFor();
      for (let i = 0; i < 6; ++i) {
        await page.getByRole('tab').nth(i).click();
        await checkAccess(page, `designer ${language} tab ${i}`);
        const wide = await page.evaluate(() => document.querySelector('.designer-side').scrollWidth - document.querySelector('.designer-side').clientWidth);
        expectEqual(wide, 0, `nothing is cut off at the side in tab ${i}`);
      }
      await page.getByRole('tab').first().click();
      await picture(page, `designer-${language}-${theme}`, { compare: true, hide: ['.booth-state'] });
    }));
}
