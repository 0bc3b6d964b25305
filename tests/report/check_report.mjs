// SPDX-License-Identifier: Apache-2.0
// Opens the report of a run in headless Chromium and uses it as a reader would: check_report.mjs WAYMARK [report.html …]
// Without reports it runs config/quickstart.yaml. Ends with 77 if there is no browser.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const tree = resolve(dirname(fileURLToPath(import.meta.url)), '../..');

function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}

const browserPath = ['chromium-headless-shell', 'chromium', 'chromium-browser', 'google-chrome']
  .flatMap((name) => process.env.PATH.split(':').map((folder) => join(folder, name))).find((path) => existsSync(path));
if (!browserPath) skip('chromium is not installed (apps/install_dependencies --with-tests)');
const { chromium } = await import('playwright-core').catch(() => skip('playwright-core is not installed (npm ci --prefix tests/report)'));

const [waymark, ...given] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'waymark-report-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));

/** Runs a configuration; gives the report. */
function run(config, out, ...options) {
  execFileSync(waymark, ['run', join(tree, 'config', config), '--out', out, ...options], { stdio: ['ignore', 'ignore', 'pipe'] });
  return join(out, 'report.html');
}

const browser = await chromium.launch({ executablePath: browserPath, args: ['--no-sandbox'] });

/** A page with a report. Fails at the first error in it and at the first request for anything but the file. */
async function open(file) {
  const page = await browser.newPage({ viewport: { width: 1400, height: 900 } });
  page.setDefaultTimeout(120_000); // a browser starts slowly beside a compiler
  const problems = [];
  page.on('pageerror', (error) => problems.push(error.stack ?? error.message));
  page.on('console', (message) => message.type() === 'error' && problems.push(message.text()));
  page.on('request', (request) => {
    if (!/^(file|data|blob):/.test(request.url())) problems.push(`asks for ${request.url()}`);
  });
  const start = performance.now();
  await page.goto(pathToFileURL(file).href);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const seconds = (performance.now() - start) / 1000;
  return { page, problems, seconds };
}

const picture = (page) => page.locator('.map canvas').evaluate((canvas) => canvas.toDataURL());

/** How many pixels of the map are not background. */
const marked = (page) => page.locator('.map canvas').evaluate((canvas) => {
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) if (Math.min(data[i], data[i + 1], data[i + 2]) < 200) ++count;
  return count;
});

const frame = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

async function checkMap(page) {
  const box = await page.locator('.map canvas').boundingBox();
  const scale = () => page.locator('.map .scale').textContent();
  assert.ok(await marked(page) > 500, 'the map is drawn');
  const whole = await picture(page);
  const firstScale = await scale();
  for (let i = 0; i < 4; ++i) await page.getByRole('button', { name: 'Zoom in' }).click();
  assert.notEqual(await scale(), firstScale, 'a click on + changes the scale');
  await page.mouse.move(box.x + 300, box.y + 200);
  await page.mouse.wheel(0, -400);
  await frame(page);
  const zoomed = await picture(page);
  await page.mouse.down();
  await page.mouse.move(box.x + 380, box.y + 260, { steps: 4 });
  await page.mouse.up();
  await page.mouse.move(box.x - 10, box.y - 10);
  await frame(page);
  assert.notEqual(await picture(page), zoomed, 'a drag moves the map');
  await page.getByRole('button', { name: 'Show all' }).click();
  await frame(page);
  assert.equal(await picture(page), whole, '"all" shows the whole map again');
  const entry = page.locator('.legend button', { hasText: 'estimate' });
  await entry.click();
  assert.equal(await entry.getAttribute('aria-pressed'), 'false');
  assert.notEqual(await picture(page), whole, 'a click in the legend hides a layer');
  await entry.click();
  assert.equal(await picture(page), whole);
}

async function checkCharts(page) {
  const chart = page.locator('.chart .u-over').first();
  await chart.scrollIntoViewIfNeeded();
  const box = await chart.boundingBox();
  const at = (share) => [box.x + share * box.width, box.y + 0.5 * box.height];
  await page.mouse.move(...at(0.5));
  await frame(page);
  assert.match(await page.locator('.readout caption').textContent(), /^Pose at /, 'the pose at the pointer\'s time is shown');
  assert.notEqual(await page.locator('.chart .at').first().textContent(), '');
  const before = await picture(page);
  await page.mouse.move(...at(0.2));
  await page.mouse.down();
  await page.mouse.move(...at(0.6), { steps: 5 });
  await page.mouse.up();
  await frame(page);
  const reset = page.getByRole('button', { name: 'Show all times' }).first();
  assert.ok(await reset.isVisible(), 'a drag over a chart enlarges a time');
  assert.notEqual(await picture(page), before, 'the map shows that part of the path');
  await page.mouse.dblclick(...at(0.5));
  await frame(page);
  assert.ok(!await reset.isVisible(), 'a double click goes back');
  await page.mouse.move(5, 5);
  await frame(page);
  assert.match(await page.locator('.readout caption').textContent(), /^Pose at the end/);
}

async function checkHealth(page) {
  const segment = page.locator('.health .bar button').first();
  await segment.click();
  await frame(page);
  const reset = page.getByRole('button', { name: 'Show all times' }).first();
  assert.ok(await reset.isVisible(), 'a click in the health bar shows that time');
  await reset.click();
  assert.ok(!await reset.isVisible());
}

async function checkTables(page) {
  const data = await page.evaluate(() => JSON.parse(document.getElementById('data').textContent));
  assert.equal(await page.locator('#sensors tbody tr').count(), data.sensors.length);
  for (const sensor of data.sensors) assert.ok(sensor.verdict, `${sensor.name} has a verdict`);
  assert.ok(!await page.locator('#config pre').isVisible());
  await page.locator('#config summary').click();
  assert.ok(await page.locator('#config pre').isVisible(), 'a click shows the configuration');
  assert.match(await page.locator('#config pre').textContent(), /^sensors:/m);
}

async function check(file) {
  const { page, problems, seconds } = await open(file);
  const size = statSync(file).size;
  assert.ok(size < 5e6, `${size} bytes`);
  await checkMap(page);
  await checkCharts(page);
  await checkHealth(page);
  await checkTables(page);
  assert.deepEqual(problems, []);
  console.log(`${file}: ${(size / 1e6).toFixed(2)} MB, opened in ${seconds.toFixed(2)} s`);
  await page.close();
}

try {
  if (given.length) {
    for (const file of given) await check(resolve(file));
  } else {
    const file = run('quickstart.yaml', join(folder, 'first'));
    await check(file);
    const again = run('quickstart.yaml', join(folder, 'second'), '--threads', '2');
    // The configuration that is shown has the number of threads.
    const page = (path) => readFileSync(path, 'utf8').replace(/"config":"(\\.|[^"])*"/, '');
    assert.ok(page(again) === page(file), 'the same run gives the same page with any number of threads');
    run('quickstart.yaml', join(folder, 'third'), '--set', 'report.enabled=false');
    assert.ok(!existsSync(join(folder, 'third/report.html')), '`report.enabled: false` leaves the page out');
  }
} finally {
  await browser.close();
}
