// Uses a page wildly for minutes, with the pointer and the sliders, and watches that it stays whole:
// node wild_dragging.mjs PAGE.html OUT.json [MINUTES [CHROMIUM]]
// OUT: {minutes, gestures, frames, slowest_s (longest time without a new frame while a gesture ran), memory_mb (first
// and last fifth, medians), errors, violations, said, not_finite, held (gestures while the solver ran), farthest (of the object's extent)}.  Exit code 1
// where something is wrong.

import fs from 'node:fs';

import {openPage} from '../app/page/browser.mjs';

const [file, out, minutes = '10', chromium = '/usr/bin/chromium'] = process.argv.slice(2);
let state = 12345;
const random = () => (state = (state * 1103515245 + 12345) % 2147483648) / 2147483648;
const between = (low, high) => low + (high - low) * random();
const pick = (list) => list[Math.floor(random() * list.length)];
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const median = (values) => values.slice().sort((a, b) => a - b)[Math.floor(values.length / 2)];

const [width, height] = [480, 400];
const page = await openPage(chromium, file, {width, height});
await page.evaluate('(async () => { await pliant.ready; await pliant.solver.ready; })()');
await page.evaluate(`(() => {
  // Frames that the animation shows, and the longest pause between two of them.
  window.watch = {frames: 0, slowest: 0, last: performance.now()};
  const tick = (now) => {
    watch.slowest = Math.max(watch.slowest, now - watch.last);
    watch.last = now;
    ++watch.frames;
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
})()`);
const rest = await page.evaluate('Array.from(window.restDrivers = pliant.drivers())');
const extent = Math.max(...[0, 1, 2].map((k) => {
  const values = rest.filter((_, i) => i % 3 === k);
  return values.reduce((a, b) => Math.max(a, b)) - values.reduce((a, b) => Math.min(a, b));
}));
const mouse = (type, x, y, button = 'left') =>
  page.send('Input.dispatchMouseEvent', {type, x, y, button, buttons: type === 'mouseReleased' ? 0 : 1, clickCount: 1});
const slide = (id, share) => page.evaluate(`(() => {
  const slider = document.getElementById('${id}');
  slider.value = Number(slider.min) + (slider.max - slider.min) * ${share};
  slider.dispatchEvent(new Event('input', {bubbles: true}));
  slider.dispatchEvent(new Event('change', {bubbles: true}));
})()`);

const end = Date.now() + 60000 * Number(minutes);
const result = {minutes: Number(minutes), gestures: 0, not_finite: 0, farthest: 0, held: 0};
const memory = [];
while (Date.now() < end) {
  const dice = random();
  if (dice < 0.12) await page.evaluate(`document.querySelector('[data-tool=${pick(['grab', 'poke', 'push', 'wind', 'pin'])}]').click()`);
  else if (dice < 0.2) await page.evaluate(`document.querySelector('[data-tool=grab]').click()`);
  else if (dice < 0.36) await slide(pick(['stiffness', 'damping', 'gravity', 'time-scale', 'wind-speed']), pick([0, 1, random()]));
  else if (dice < 0.39) await page.evaluate(`document.getElementById('${pick(['reset', 'replay', 'clip-camera', 'fit'])}').click()`);
  else {
    let [x, y] = [between(0.25, 0.75) * width, between(0.15, 0.75) * height];
    await mouse('mousePressed', x, y);
    await wait(30);
    if (await page.evaluate('pliant.live()')) ++result.held;
    for (let k = Math.floor(between(2, 15)); k > 0; --k) {
      [x, y] = [x + between(-120, 120), y + between(-120, 120)];
      await mouse('mouseMoved', x, y);
      await wait(between(0, 60));
    }
    await mouse('mouseReleased', x, y);
  }
  ++result.gestures;
  if (result.gestures % 10 === 0) {
    const now = await page.evaluate(`(() => {
      const x = pliant.drivers();
      let finite = true, far = 0;
      const rest = window.restDrivers;
      for (let i = 0; i < x.length; ++i) {
        finite = finite && Number.isFinite(x[i]);
        if (x.length === rest.length) far = Math.max(far, Math.abs(x[i] - rest[i]));
      }
      return {finite, far, bytes: performance.memory?.usedJSHeapSize ?? 0};
    })()`);
    if (!now.finite) ++result.not_finite;
    result.farthest = Math.max(result.farthest, now.far / extent);
    const {usedSize} = await page.send('Runtime.getHeapUsage');
    memory.push((now.bytes || usedSize) / 1e6);
  }
}
const fifth = Math.max(1, Math.floor(memory.length / 5));
result.memory_mb = [median(memory.slice(0, fifth)), median(memory.slice(-fifth))];
Object.assign(result, await page.evaluate(`(() => ({frames: watch.frames, slowest_s: watch.slowest / 1000,
  errors: pliant.errors.map(String), violations: pliant.violations,
  alert: document.getElementById('alert').hidden ? '' : document.getElementById('alert-text').textContent}))()`));
result.said = page.said;
fs.writeFileSync(out, JSON.stringify(result, null, 1) + '\n');
console.log(JSON.stringify(result));
await page.close();
const wrong = result.not_finite || result.errors.length || result.violations.length || result.said.length || result.alert;
process.exit(wrong ? 1 : 0);
