// A page in headless Chromium: a file without a network, or what a server of this machine has.

import {spawn} from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';

/**
 * Opens a page from its file or its address (http://...); resolves when it is loaded.  {send(method, params): a command
 * of the DevTools protocol, evaluate(expression): its value, said: what the console said and what was thrown, ended: a
 * promise, close()}.
 */
export async function openPage(chromium, page, {width = 480, height = 400} = {}) {
  const profile = fs.mkdtempSync(path.join(os.tmpdir(), 'pliant_browser_'));
  const browser = spawn(chromium, [
    '--headless=new', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-first-run',
    '--remote-debugging-pipe', `--user-data-dir=${profile}`, `--window-size=${width},${height}`, 'about:blank',
  ], {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'], env: {...process.env, TMPDIR: profile}});
  const waiting = new Map(), said = [];
  let last = 0, rest = '';
  const command = (method, params = {}, sessionId = undefined) => new Promise((resolve, reject) => {
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
        waiting.delete(message.id);
        message.error ? reject(new Error(message.error.message)) : resolve(message.result);
      } else if (message.method === 'Runtime.consoleAPICalled' && message.params.type !== 'log') {
        said.push(message.params.args.map((a) => a.value ?? a.description).join(' '));
      } else if (message.method === 'Runtime.exceptionThrown') {
        said.push(message.params.exceptionDetails.exception?.description ?? message.params.exceptionDetails.text);
      }
    }
  });
  const ended = new Promise((done) => browser.on('exit', done));
  const close = async () => {
    browser.kill('SIGKILL');
    await ended;
    // Helpers of the browser may write for a moment longer.
    for (let left = 40; fs.existsSync(profile); --left) {
      try {
        fs.rmSync(profile, {recursive: true, force: true});
      } catch (error) {
        if (left === 0) throw error;
        await new Promise((done) => setTimeout(done, 50));
      }
    }
  };
  const {targetId} = await command('Target.createTarget', {url: 'about:blank'});
  const {sessionId} = await command('Target.attachToTarget', {targetId, flatten: true});
  const send = (method, params) => command(method, params, sessionId);
  await send('Runtime.enable');
  await send('Network.enable');
  const served = page.startsWith('http://');
  const network = {offline: !served, latency: 0, downloadThroughput: served ? -1 : 0, uploadThroughput: served ? -1 : 0};
  await send('Network.emulateNetworkConditions', network);
  await send('Page.enable');
  await send('Page.navigate', {url: served ? page : 'file://' + path.resolve(page)});
  const evaluate = async (expression) => {
    const answer = await send('Runtime.evaluate', {expression, awaitPromise: true, returnByValue: true});
    const wrong = answer.exceptionDetails;
    if (wrong) throw new Error(wrong.exception?.description ?? wrong.text);
    return answer.result.value;
  };
  while (await evaluate('document.readyState + location.protocol') !== (served ? 'completehttp:' : 'completefile:'))
    await new Promise((done) => setTimeout(done, 100));
  return {send, evaluate, said, ended, close};
}
