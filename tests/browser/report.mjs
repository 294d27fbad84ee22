// Opens reports from disk in headless Chromium and does with them what a reader does. Arguments: CHROMIUM REPORT PAIR SEQUENCE
// TRACK [PICTURES]: the reports of one result, of two, of a sequence and of a recording, and a folder for screenshots.

import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { statSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const [executablePath, report, pair, sequence, track, pictures] = process.argv.slice(2);
const SIZES = { desktop: { width: 1280, height: 800 }, phone: { width: 390, height: 844 } };
/** Time to interactive that is allowed here, ms: 2 s on a desktop, and as much again where others share the processor. */
const MOST_MS = 4000;

const browser = await chromium.launch({
  executablePath,
  // Pixels from the processor alone: the same on every machine.
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-dev-shm-usage'],
});

/** Opens `file` at `size` and hands its page to `check`; no request and no error may come about. */
async function opened(file, size, check, options = {}) {
  const context = await browser.newContext({ viewport: size, ...options });
  const page = await context.newPage();
  const own = pathToFileURL(resolve(file)).href;
  const requests = [], errors = [];
  page.on('request', (request) => request.url() !== own && !request.url().startsWith('data:') && requests.push(request.url()));
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(own);
  await page.waitForFunction(() => document.documentElement.dataset.ready, null, { timeout: 60000 });
  assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), 'true', await page.textContent('#failure'));
  await settled(page);
  await check(page);
  assert.deepEqual(requests, [], 'no request leaves the page');
  // Chromium says once that pixels are read back from a software canvas.
  assert.deepEqual(errors.filter((text) => !/GPU stall due to ReadPixels|swiftshader/i.test(text)), [], 'nothing is logged');
  await context.close();
}

/** The picture of the face as a digest; of the canvas itself, as what lies over it is not blended the same way every time. */
const pixels = async (page) =>
  createHash('sha256').update(await page.locator('#canvas').evaluate((canvas) => canvas.toDataURL())).digest('hex');
const settled = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
const vertices = (page, k = 0) => page.evaluate((k) => Array.from(window.modiolusReport.positions(k)), k);
const farthest = (a, b) => a.reduce((most, x, k) => Math.max(most, Math.abs(x - b[k])), 0);
const picture = async (page, name) => pictures && page.screenshot({ path: join(pictures, `${name}.png`) });

async function set(page, selector, value) {
  await page.locator(selector).evaluate((input, value) => {
    input.value = value;
    input.dispatchEvent(new Event('input', { bubbles: true }));
  }, String(value));
  await settled(page);
}

/** A slider moves the skin and the picture; the answer comes back. */
async function slides(page) {
  const before = [await vertices(page), await pixels(page)];
  const k = await page.evaluate(() => window.modiolusReport.results[0].face.muscles.findIndex((m) => m.name === 'zygomaticus_major_l'));
  const was = Number(await page.locator(`#slider-${k}`).inputValue());
  await set(page, `#slider-${k}`, was > 50 ? 0 : 100);
  const moved = await vertices(page);
  assert.ok(farthest(before[0], moved) > 0.5, 'the skin moves by a slider');
  assert.notEqual(await pixels(page), before[1], 'the picture changes with it');
  assert.match(await page.textContent('#mode'), /Linear/);
  // Superposition: half the step is half the way.
  await set(page, `#slider-${k}`, was > 50 ? was / 2 : 50 + was / 2);
  const half = await vertices(page);
  const off = half.reduce((most, x, j) => Math.max(most, Math.abs(x - (before[0][j] + moved[j]) / 2)), 0);
  assert.ok(off < 0.02 * farthest(before[0], moved), `half a step is half the way, to rounding of a per cent: ${off}`);
  await page.click('#to-answer');
  await settled(page);
  assert.ok(farthest(before[0], await vertices(page)) < 1e-4, 'the answer comes back');
}

/** It plays from the first state to the last, moving. */
async function plays(page) {
  await set(page, '#time', 0);
  const first = await vertices(page);
  // A phone has no room for it.
  await page.locator('#speed').evaluate((select) => (select.value = '0.5'));
  await page.click('#play');
  await page.waitForFunction(() => Number(document.getElementById('time').value) > 150);
  await settled(page);
  const amid = await vertices(page);
  assert.ok(farthest(first, amid) > 0.1, 'the skin moves as it plays');
  await page.waitForFunction(() => document.getElementById('time').value === '1000', null, { timeout: 30000 });
  await page.waitForFunction(() => document.getElementById('play').getAttribute('aria-pressed') === 'false');
  await settled(page);
  assert.ok(farthest(amid, await vertices(page)) > 0.1, 'and goes on to the last state');
}

/** Frames of a recording: it opens where the muscles do most, markers go with the frames, and one that was not seen is not shown. */
async function tracks(page) {
  const moment = () => page.textContent('#moment');
  assert.match(await moment(), /^frame \d+, \d\.\d\d s$/);
  assert.match(await page.textContent('#notes'), /Every 4th of 120 frames, 30 in all/);
  assert.ok(await page.locator('#to-answer').isHidden(), 'there is no answer to go to');
  const marks = (name) => page.evaluate((name) => {
    const { result, marks } = window.modiolusReport.drawn[0];
    const k = result.json.markers.findIndex((marker) => marker.name === name);
    return ['measured', 'model'].map((set) => Array.from(marks[set][0].instanceMatrix.array.slice(16 * k, 16 * k + 16)));
  }, name);
  const height = ([matrix]) => matrix[13];
  await set(page, '#time', 0);
  const rest = height(await marks('cheilion_l'));
  await set(page, '#time', 500);
  const raised = await marks('cheilion_l');
  assert.ok(height(raised) - rest > 3, 'the measured marker goes up');
  assert.ok(Math.abs(raised[0][13] - raised[1][13]) < 2.5, 'and the model follows');
  await set(page, '#time', 410);
  assert.equal((await marks('cheilion_r'))[0][0], 0, 'what was not seen is not shown');
  assert.equal((await marks('cheilion_l'))[0][0], 1);
  await plays(page);
  await fits(page);
}

/** Every view is another picture; keys turn the face. */
async function looks(page) {
  const seen = new Set();
  const buttons = page.locator('#views button[aria-pressed]');
  for (let k = 0; k < (await buttons.count()); k++) {
    await buttons.nth(k).click();
    await settled(page);
    seen.add(await pixels(page));
    assert.equal(await buttons.nth(k).getAttribute('aria-pressed'), 'true');
  }
  assert.equal(seen.size, await buttons.count(), 'each view is its own');
  await page.focus('#canvas');
  await page.keyboard.press('1');
  await settled(page);
  const front = await pixels(page);
  await page.keyboard.press('ArrowRight');
  await settled(page);
  assert.notEqual(await pixels(page), front, 'an arrow key turns the face');
  await page.keyboard.press('1');
  await settled(page);
  assert.equal(await pixels(page), front, 'and the same view is the same picture');
}

/** Colours, what is shown, and the legend in its unit. */
async function colours(page) {
  const seen = new Set([await pixels(page)]);
  for (const [map, unit] of [['displacement', 'mm'], ['stretch', '%'], ['asymmetry', 'mm'], ['pressure', 'kPa'], ['none', '']]) {
    await page.selectOption('#colour', map);
    await settled(page);
    seen.add(await pixels(page));
    assert.match(await page.textContent('#legend-title'), new RegExp(unit));
    await picture(page, `colour_${map}`);
  }
  assert.ok(seen.size >= 5, `each map has its colours: ${seen.size}`);
  await page.check('#show-muscles');
  await settled(page);
  assert.ok(!seen.has(await pixels(page)), 'muscles show through the skin');
  assert.equal(await page.inputValue('#skin'), 'veil');
  await picture(page, 'muscles');
}

/** Every control can be reached by the keyboard and has a name. */
async function named(page) {
  const nameless = await page.evaluate(() => [...document.querySelectorAll('button, select, input, canvas')].filter((e) => {
    const label = e.labels?.length ? e.labels[0].textContent : '';
    return !(e.getAttribute('aria-label') ?? label ?? e.textContent).trim() && !e.textContent.trim();
  }).map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
}

/** Nothing is wider than the page. */
async function fits(page) {
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), 'no sideways scrolling');
}

let readyMs = Infinity;
for (const [size, viewport] of Object.entries(SIZES)) {
  await opened(report, viewport, async (page) => {
    readyMs = Math.min(readyMs, await page.evaluate(() => window.modiolusReport.readyMs));
    await picture(page, `${size}_front`);
    await slides(page);
    await plays(page);
    await fits(page);
    if (size === 'desktop') {
      await looks(page);
      await colours(page);
      await named(page);
    } else await picture(page, 'phone');
  });
  await opened(pair, viewport, async (page) => {
    await fits(page);
    await picture(page, `${size}_pair`);
    const both = await pixels(page);
    for (const name of ['Result A alone', 'Result B alone', 'Both results']) {
      await page.getByRole('button', { name, exact: true }).click();
      await settled(page);
      if (name !== 'Both results') assert.notEqual(await pixels(page), both, `${name} is another picture`);
    }
    assert.equal(await pixels(page), both, 'both are back');
  });
}
await opened(sequence, SIZES.desktop, plays);
for (const [size, viewport] of Object.entries(SIZES)) {
  await opened(track, viewport, async (page) => {
    await picture(page, `${size}_track`);
    await tracks(page);
  });
}
await opened(report, SIZES.desktop, (page) => picture(page, 'dark'), { colorScheme: 'dark' });
if (pictures) {
  await opened(report, SIZES.desktop, async (page) => {
    await page.pdf({ path: join(pictures, 'print.pdf'), format: 'A4' });
    await page.getByRole('button', { name: /^Right profile/ }).click();
    await settled(page);
    await picture(page, 'profile');
    await page.getByRole('button', { name: /^From inside/ }).click();
    await page.selectOption('#colour', 'pressure');
    await settled(page);
    await picture(page, 'inside');
  });
  await opened(report, { width: 1280, height: 2600 }, (page) => picture(page, 'whole'));
}
await browser.close();
assert.ok(readyMs < MOST_MS, `interactive after ${Math.round(readyMs)} ms`);
const megabytes = (file) => (statSync(file).size / 1e6).toFixed(2);
console.log(`interactive after ${Math.round(readyMs)} ms; ${megabytes(report)} MB of one result, ${megabytes(pair)} MB of two, ${megabytes(track)} MB of 30 frames`);
