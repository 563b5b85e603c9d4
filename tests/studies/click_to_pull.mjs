// From a click on an object of a scene to pulling it, in headless Chromium on a page that the program serves:
// node click_to_pull.mjs PLIANT SCENE OUT [VIEW [X Y [CHROMIUM]]]
// VIEW: the picture to click in; X, Y: the place, as shares of it.  OUT gets run/, pictures of every step and click_to_pull.json: seconds of the preparation,
// from the click to the selection, from "Make it move" to a page that can be pulled and to the first frame of a pull;
// how far the pull moved the particles (of the object's extent).  Exit code 1 where something is wrong.

import {spawn} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';

import {openPage} from '../app/page/browser.mjs';

const [pliant, scene, out, view = '0', x = '0.5', y = '0.5', chromium = '/usr/bin/chromium'] = process.argv.slice(2);
fs.mkdirSync(out, {recursive: true});
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const [width, height] = [1280, 720];
const begin = Date.now();
const program = spawn(pliant, ['view', scene, '--out', path.join(out, 'run'), '--choose', '--no-browser', '--port', '0']);
let text = '';
const steps = [];
for (const stream of [program.stdout, program.stderr]) stream.on('data', (data) => {
  text += data;
  for (const line of String(data).split('\n'))
    if (/: [\d.]+ s$/.test(line)) steps.push([seconds(begin), line]);
});
const seconds = (since) => (Date.now() - since) / 1000;
const result = {};

/** Waits until `done` answers with something; `done` may fail while a page is being left. */
async function until(what, done, most = 300) {
  for (const since = Date.now(); seconds(since) < most; await wait(20)) {
    if (program.exitCode !== null) throw new Error('the program ended: ' + text);
    const answer = await Promise.resolve().then(done).catch(() => null);
    if (answer) return answer;
  }
  throw new Error(`${what}: not within ${most} s: ${text}`);
}

let page;
try {
  const url = await until('address', () => text.match(/http:\/\/\S+\//)?.[0]);
  page = await openPage(chromium, url, {width, height});
  const picture = async (name) => {
    const {data} = await page.send('Page.captureScreenshot', {format: 'png'});
    fs.writeFileSync(path.join(out, name + '.png'), Buffer.from(data, 'base64'));
  };
  const mouse = (type, [px, py]) => page.send('Input.dispatchMouseEvent', {
    type, x: px, y: py, button: 'left', buttons: type === 'mouseReleased' ? 0 : 1, clickCount: 1});
  await page.evaluate('Promise.all(data.views.map((view) => view.image.decode())).then(() => 1)');
  await until('connection', () => page.evaluate('socket.readyState === WebSocket.OPEN'));
  await page.evaluate(`turn(${Number(view)} - at); useTool('click')`);
  result.preparation_s = seconds(begin);
  await picture('1_choose');

  const place = await page.evaluate(`(() => {
    const box = canvas.getBoundingClientRect(), view = data.views[at];
    const scale = Math.min(box.width / view.width, box.height / view.height);
    return [box.left + box.width / 2 + scale * view.width * (${x} - 0.5),
            box.top + box.height / 2 + scale * view.height * (${y} - 0.5)];
  })()`);
  const click = Date.now();
  await mouse('mousePressed', place);
  await mouse('mouseReleased', place);
  await until('selection', () => page.evaluate(`element('selection').textContent.includes('selected')`));
  result.selection_s = seconds(click);
  result.selection = await page.evaluate(`element('selection').textContent`);
  await picture('2_selected');

  const make = Date.now();
  result.make_at = seconds(begin);
  await page.evaluate(`element('make').click()`);
  await until('moving page', () => page.evaluate(`typeof pliant.live === 'function'`));
  result.make_s = seconds(make);
  result.click_to_pull_s = result.selection_s + result.make_s;
  await picture('3_ready');

  const moved = () => page.evaluate(`(() => {
    const now = pliant.drivers(), rest = window.rest, low = [1e9, 1e9, 1e9], high = [-1e9, -1e9, -1e9];
    let most = 0;
    for (let i = 0; i < rest.length; ++i) {
      most = Math.max(most, Math.abs(now[i] - rest[i]));
      low[i % 3] = Math.min(low[i % 3], rest[i]);
      high[i % 3] = Math.max(high[i % 3], rest[i]);
    }
    return most / Math.max(...high.map((h, k) => h - low[k]));
  })()`);
  // Where the object is on the screen: the middle of what the page frames.
  const from = [0.5 * width, 0.45 * height], to = [0.62 * width, 0.38 * height];
  const pull = Date.now();
  await mouse('mousePressed', from);
  // The level that is simulated has drivers of its own.
  await until('hold', () => page.evaluate('pliant.live()'), 60);
  await page.evaluate(`window.rest = Array.from(pliant.drivers())`);
  await mouse('mouseMoved', to);
  await until('motion', async () => await moved() > 1e-3, 60);
  result.first_motion_s = seconds(pull);
  await wait(4000);
  result.moved = await moved();
  await picture('4_pulled');
  await mouse('mouseReleased', to);
  await wait(4000);
  result.moved_after = await moved();
  await picture('5_released');
  result.said = page.said;
  result.program = steps;
} catch (error) {
  result.error = String(error.message ?? error);
} finally {
  await page?.close();
  program.kill('SIGINT');
}
fs.writeFileSync(path.join(out, 'click_to_pull.json'), JSON.stringify(result, null, 1) + '\n');
console.log(JSON.stringify(result, null, 1));
process.exit(result.error || result.said?.length ? 1 : 0);
