// Opens a page in headless Chromium, without a network, and evaluates an expression there:
// node browse_clip.mjs CHROMIUM PAGE.html EXPRESSION.js OUT.json
// The expression may be a promise.  OUT: {value} or {error}, and what the console said.

import {spawn} from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';

const [chromium, page, expression, out] = process.argv.slice(2);
const profile = fs.mkdtempSync(path.join(os.tmpdir(), 'pliant_browser_'));
const browser = spawn(chromium, [
  '--headless=new', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-first-run',
  '--remote-debugging-pipe', `--user-data-dir=${profile}`, '--window-size=480,400', 'about:blank',
], {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
const waiting = new Map(), said = [];
let last = 0, rest = '';
const send = (method, params = {}, sessionId = undefined) => new Promise((resolve, reject) => {
  waiting.set(++last, {resolve, reject});
  browser.stdio[3].write(JSON.stringify({id: last, method, params, sessionId}) + '\0');
});
browser.stdio[4].on('data', (data) => {
  const messages = (rest + data).split('\0');
  rest = messages.pop();
  for (const text of messages) {
    const message = JSON.parse(text);
    if (message.id) {
      const {resolve, reject} = waiting.get(message.id);
      message.error ? reject(new Error(message.error.message)) : resolve(message.result);
    } else if (message.method === 'Runtime.consoleAPICalled' && message.params.type !== 'log') {
      said.push(message.params.args.map((a) => a.value ?? a.description).join(' '));
    } else if (message.method === 'Runtime.exceptionThrown') {
      said.push(message.params.exceptionDetails.exception?.description ?? message.params.exceptionDetails.text);
    }
  }
});
let finished = false;
const finish = (result) => {
  if (finished) return;
  finished = true;
  fs.writeFileSync(out, JSON.stringify({...result, said}));
  browser.kill('SIGKILL');
  // Helpers of the browser may write for a moment longer.
  try {
    fs.rmSync(profile, {recursive: true, force: true, maxRetries: 5, retryDelay: 30});
  } finally {
    process.exit(0);
  }
};
browser.on('exit', () => finish({error: 'the browser ended'}));
setTimeout(() => finish({error: 'no answer within two minutes'}), 120000);
try {
  const {targetId} = await send('Target.createTarget', {url: 'about:blank'});
  const {sessionId} = await send('Target.attachToTarget', {targetId, flatten: true});
  await send('Runtime.enable', {}, sessionId);
  await send('Network.enable', {}, sessionId);
  await send('Network.emulateNetworkConditions',
      {offline: true, latency: 0, downloadThroughput: 0, uploadThroughput: 0}, sessionId);
  await send('Page.enable', {}, sessionId);
  await send('Page.navigate', {url: 'file://' + path.resolve(page)}, sessionId);
  for (let ready = false; !ready; await new Promise((done) => setTimeout(done, 100))) {
    const state = await send('Runtime.evaluate', {expression: 'document.readyState + location.protocol'}, sessionId);
    ready = state.result.value === 'completefile:';
  }
  const answer = await send('Runtime.evaluate',
      {expression: fs.readFileSync(expression, 'utf8'), awaitPromise: true, returnByValue: true}, sessionId);
  const wrong = answer.exceptionDetails;
  finish(wrong ? {error: wrong.exception?.description ?? wrong.text} : {value: answer.result.value});
} catch (error) {
  finish({error: error.message});
}
