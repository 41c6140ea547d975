// Measuring by hand on a head of the simulated booth.
import { checkAccess, expect, expectEqual, picture, test, until } from './harness.mjs';
import { stationWithHead, withPage } from './measure_head.mjs';

export const begin = (browser) => stationWithHead(browser);
export const end = ({ station }) => station.stop();

const measure = (browser, common, look, run) => withPage(browser, common, `/scans/${common.scan}/measure`, look, run);
const tab = (page, name) => page.getByRole('tab', { name, exact: true }).click();

/** Taps the picture at shares of its width and height. */
async function tap(page, x, y) {
  const box = await page.locator('.view3d').first().boundingBox();
  await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
}

/** The first number that a tool says, in its unit. */
async function result(page, which = 0) {
  const text = await page.locator('.result-list strong').nth(which).innerText({ timeout: 10_000 }).catch(() => '');
  return Number.parseFloat(text);
}

/** Drags an element by pixels. */
async function drag(page, element, dx, dy) {
  const box = await element.boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 8; ++i) await page.mouse.move(x + (dx * i) / 8, y + (dy * i) / 8);
  await page.mouse.up();
}

test('two points are tapped, one is dragged along the surface, and the distance follows', (browser, common) =>
  measure(browser, common, {}, async (page) => {
    await tap(page, 0.46, 0.5);
    await page.getByRole('button', { name: /^Point A/ }).waitFor();
    await tap(page, 0.54, 0.5);
    const first = await until('a length is said', () => result(page));
    expect(first > 5 && first < 300, `a length over a face: ${first} mm`);
    await page.locator('.view3d-label', { hasText: '±' }).waitFor();
    await drag(page, page.getByRole('button', { name: /^Point B/ }), 0, -70);
    await until('the length has become another', async () => Math.abs((await result(page)) - first) > 1);
    await picture(page, 'measure-distance');
    await checkAccess(page, 'distance');
  }));

test('tape, shortest way, plane and line of sight give lengths in the order that geometry asks for', (browser, common) =>
  measure(browser, common, {}, async (page) => {
    await tap(page, 0.45, 0.48);
    await page.getByRole('button', { name: /^Point A/ }).waitFor();
    await tap(page, 0.55, 0.48);
    const tape = await until('by tape', () => result(page));
    const straight = await result(page, 1);
    await page.getByText('Shortest way', { exact: true }).click();
    const geodesic = await until('the shortest way', async () => (await page.locator('.result-list dt').first().innerText()) === 'Shortest way' && result(page));
    await page.getByText('Line of sight', { exact: true }).click();
    const sight = await until('by line of sight', async () => (await page.locator('.result-list dt').first().innerText()) === 'Line of sight' && result(page));
    await page.getByText('Plane ABC', { exact: true }).click();
    await page.getByText('Tap the body for point C.').waitFor();
    await tap(page, 0.5, 0.4);
    const plane = await until('by plane', async () => (await page.locator('.result-list dt').first().innerText()) === 'Plane ABC' && result(page));
    // A chord is below a taut tape, that below the shortest way on the skin, that below any cut (0.2 mm for rounding and nets).
    expect(straight <= tape + 0.2 && tape <= geodesic + 0.2, `chord ${straight}, tape ${tape}, geodesic ${geodesic}`);
    expect(geodesic <= sight + 0.2 && geodesic <= plane + 0.2, `geodesic ${geodesic}, sight ${sight}, plane ${plane}`);
  }));

test('the level is drawn down by hand and by keys, and the girth follows', (browser, common) =>
  measure(browser, common, {}, async (page) => {
    await tab(page, 'Girth');
    const first = await until('a girth is said', () => result(page));
    expect(first > 300 && first < 800, `a head’s girth: ${first} mm`);
    expect((await result(page, 1)) >= first - 0.05, 'the outline is no shorter than the tape');
    const handle = page.getByRole('button', { name: /^Height of the section/ });
    await drag(page, handle, 0, 90);
    const second = await until('the girth has become another', async () => {
      const now = await result(page);
      return Math.abs(now - first) > 1 && now;
    });
    await handle.focus();
    for (let i = 0; i < 3; ++i) await page.keyboard.press('PageDown');
    await until('keys move it too', async () => Math.abs((await result(page)) - second) > 0.2);
    await picture(page, 'measure-girth');
    await checkAccess(page, 'girth');
  }));

test('volume and area between two planes grow as they are drawn apart', (browser, common) =>
  measure(browser, common, {}, async (page) => {
    await tab(page, 'Volume');
    await until('a volume is said', () => result(page));
    const [volume, area] = [await result(page), await result(page, 1)];
    await drag(page, page.getByRole('button', { name: 'Upper plane', exact: true }), 0, -40);
    await until('both have grown', async () => (await result(page)) > volume && (await result(page, 1)) > area);
    await picture(page, 'measure-volume');
    await checkAccess(page, 'volume');
  }));

test('a region is cut by the planes of four points', (browser, common) =>
  measure(browser, common, {}, async (page) => {
    await tab(page, 'Region');
    for (const [name, x, y] of [['A', 0.45, 0.35], ['B', 0.55, 0.35], ['C', 0.5, 0.28], ['D', 0.5, 0.42]]) {
      await tap(page, x, y);
      await page.getByRole('button', { name: new RegExp(`^Point ${name}`) }).waitFor();
    }
    const area = await until('an area is said', () => result(page));
    expect(area > 1 && area < 500, `an area on a forehead: ${area} cm²`);
    await picture(page, 'measure-region');
    await checkAccess(page, 'region');
  }));

test('a landmark that is moved changes its measurements, which are marked; all goes back', (browser, common) =>
  measure(browser, common, {}, async (page) => {
    await tab(page, 'Landmarks');
    const row = page.locator('.landmark', { hasText: 'ragion' }).first();
    await row.waitFor();
    await row.click();
    const handle = page.locator('.cursor-handle:focus');
    await handle.waitFor();
    for (let i = 0; i < 2; ++i) await page.keyboard.press('Shift+ArrowUp');
    await page.locator('tr.changed').first().waitFor();
    expectEqual(await page.locator('.failure').count(), 0, 'failures among the landmarks');
    await page.locator('.landmark .badge', { hasText: 'by hand' }).first().waitFor();
    await picture(page, 'measure-landmarks');
    await checkAccess(page, 'landmarks');
    await page.getByRole('button', { name: 'All as found' }).click();
    await until('none is by hand', async () => (await page.locator('.landmark .badge', { hasText: 'by hand' }).count()) === 0);
  }));

test('two visits are compared side by side', (browser, common) =>
  measure(browser, common, {}, async (page) => {
    await tab(page, 'Compare');
    await page.getByRole('combobox', { name: 'Other visit' }).selectOption(common.earlier);
    await page.locator('.view3d canvas').nth(1).waitFor();
    await page.getByText(/measurements differ significantly/).waitFor();
    expect((await page.locator('.designer-side tbody tr').count()) >= 3, 'differences are listed');
    await page.locator('.designer-side tbody .link').first().click();
    await picture(page, 'measure-compare', { hide: ['.booth-date', 'select[name=other]'] });
    await checkAccess(page, 'compare');
  }));

test('everybody can use it on a tablet in Japanese and dark colours', (browser, common) =>
  measure(browser, common, { viewport: { width: 1024, height: 768 }, colorScheme: 'dark' }, async (page) => {
    await page.getByRole('button', { name: '日本語' }).click();
    await page.getByRole('tab', { name: '距離' }).waitFor();
    for (let i = 0; i < 6; ++i) {
      await page.getByRole('tab').nth(i).click();
      await checkAccess(page, `measuring, tab ${i}`);
    }
    await page.getByRole('tab', { name: '周長' }).click();
    await picture(page, 'measure-ja-dark');
  }));
