// Runs the browser tests: all, or those of the files named (`node run.mjs operator`). Ends with "N passed, N failed".
import { readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { openBrowser, tests } from './harness.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const wanted = process.argv.slice(2);
const files = readdirSync(here)
  .filter((file) => file.endsWith('_test.mjs'))
  .filter((file) => wanted.length === 0 || wanted.some((name) => file.startsWith(name)))
  .sort();

let passed = 0;
let failed = 0;
const browser = await openBrowser();
for (const file of files) {
  tests.length = 0;
  // A file may export begin(), whose answer each of its tests is given, and end(), which is given it at the end.
  const { begin, end } = await import(pathToFileURL(join(here, file)).href);
  console.log(file);
  let common;
  try {
    common = await begin?.(browser);
  } catch (error) {
    failed += tests.length;
    console.log(`  FAIL begin: ${error.stack ?? error}`);
    continue;
  }
  for (const { name, run } of tests) {
    const from = Date.now();
    try {
      await run(browser, common);
      passed += 1;
      console.log(`  ok   ${name} (${((Date.now() - from) / 1000).toFixed(1)} s)`);
    } catch (error) {
      failed += 1;
      console.log(`  FAIL ${name} (${((Date.now() - from) / 1000).toFixed(1)} s)\n       ${String(error.stack ?? error).replaceAll('\n', '\n       ')}`);
    }
  }
  await end?.(common);
}
await browser.close();
console.log(`${passed} passed, ${failed} failed`);
process.exitCode = failed > 0 || passed === 0 ? 1 : 0;
