'use strict';
// The choice of an object: what is chosen, and the tools.  The files choose*.js are one script, of which this is the
// first; functions are seen by all of them.

const data = JSON.parse(document.getElementById('data').textContent);
const element = (id) => document.getElementById(id);
let names = new Map(data.things.map((thing) => [thing.id, thing]));
// Marks in the order in which they were made; what was undone can be made again.
let marks = data.marks;
let undone = [];
// `chosen` is an object, or what is selected by marks; `cross` is where the keyboard has put the next mark.
const SELECTION = -1;
let at = 0, over = 0, chosen = 0, tool = 'take', busy = '', line = null, cross = null, hoverAt = 0;
if (marks.length) chosen = data.things[0]?.id ?? 0;

function update() {
  for (const input of document.querySelectorAll('input[name=thing]')) input.checked = Number(input.value) === chosen;
  for (const button of document.querySelectorAll('[data-tool]')) {
    button.setAttribute('aria-pressed', button.dataset.tool === tool);
    button.disabled = Boolean(busy);
  }
  element('make').disabled = !chosen || Boolean(busy);
  for (const [id, step] of [['grow', 1], ['shrink', -1]]) element(id).disabled = !canGrow(step);
  element('undo').disabled = !marks.length || Boolean(busy);
  element('redo').disabled = !undone.length || Boolean(busy);
  const selected = chosen === SELECTION || (marks.length > 0 && chosen === data.things[0]?.id);
  element('naming').hidden = !selected || Boolean(busy);
  element('find').disabled = Boolean(busy);
  element('work').hidden = !busy;
  draw();
}

function choose(id) {
  if (chosen === SELECTION && id !== SELECTION && !busy) {  // the marks count no more
    send({select: {}});
    element('selection').textContent = '';
  }
  chosen = id;
  update();
}

element('title').textContent = data.title;

for (const button of document.querySelectorAll('[data-tool]'))
  button.onclick = () => useTool(button.dataset.tool);

function useTool(name) {
  tool = name;
  over = 0;
  line = null;
  clearTimeout(hoverAt);
  clearHint();
  update();
}

element('undo').onclick = undo;
element('redo').onclick = redo;
element('grow').onclick = () => growBy(1);
element('shrink').onclick = () => growBy(-1);

const letters = {t: 'take', p: 'click', b: 'box', a: 'fg', r: 'bg'};
document.onkeydown = (event) => {
  if (event.target instanceof HTMLInputElement && event.target.type === 'text') return;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    const again = key === 'y' || (key === 'z' && event.shiftKey);
    if (busy || (key !== 'z' && key !== 'y') || !(again ? undone : marks).length) return;
    event.preventDefault();
    return again ? redo() : undo();
  }
  if (key === '+' || key === '-') return growBy(key === '+' ? 1 : -1);
  if (key in letters && !event.altKey && !busy) useTool(letters[key]);
};
