// Opens a page in headless Chromium, without a network, and evaluates an expression there:
// node browse_clip.mjs CHROMIUM PAGE.html EXPRESSION.js OUT.json
// The expression may be a promise.  OUT: {value} or {error}, and what the console said.

import fs from 'node:fs';

import {openPage} from './browser.mjs';

const [chromium, file, expression, out] = process.argv.slice(2);
let page = null;
let finished = false;
const finish = async (result) => {
  if (finished) return;
  finished = true;
  fs.writeFileSync(out, JSON.stringify({...result, said: page?.said ?? []}));
  try {
    await page?.close();
  } finally {
    process.exit(0);
  }
};
setTimeout(() => finish({error: 'no answer within two minutes'}), 120000);
try {
  page = await openPage(chromium, file);
  page.ended.then(() => finish({error: 'the browser ended'}));
  finish({value: await page.evaluate(fs.readFileSync(expression, 'utf8'))});
} catch (error) {
  finish({error: error.message});
}
