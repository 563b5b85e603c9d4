// The marks by which something is selected: they are made, undone, and sent to the program.

/** Points of a mark in the pixels of a view; none where it was made in another. */
function pointsIn(mark, view) {
  if (mark.kind === 'grow') return [];
  const words = mark.text.split(',');
  if (mark.kind === 'stroke') words.shift();
  if (Number(words.shift()) !== view.camera) return [];
  const out = [], [across, down] = view.scale;
  for (let k = 0; k + 1 < words.length; k += 2) out.push([words[k] / across, words[k + 1] / down]);
  return out;
}

function textOf([x, y]) {
  const [across, down] = data.views[at].scale;
  return `${(x * across).toFixed(1)},${(y * down).toFixed(1)}`;
}

/** Marks in the order in which they were made. */
function addMarks(more) {
  marks.push(...more);
  undone = [];
  ask();
}

/** Marks that count, as segment_by of marks.h takes them: a box in a view takes the place of an earlier one there. */
function currentMarks() {
  const cameraOf = (mark) => mark.text.split(',')[0];
  return marks.filter((mark, k) => mark.kind !== 'box' ||
    !marks.slice(k + 1).some((later) => later.kind === 'box' && cameraOf(later) === cameraOf(mark)));
}

/** How far the selection is grown, or shrunk where it is negative. */
const grown = () => marks.reduce((sum, mark) => sum + (mark.kind === 'grow' ? Number(mark.text) : 0), 0);

const canGrow = (step) => marks.length && !busy && Math.abs(grown() + step) <= data.maxGrow;

function growBy(step) {
  if (!canGrow(step)) return;
  marks.push({kind: 'grow', text: String(step)});
  undone = [];
  ask();
}

let asked = false;  // for the marks of this page

/** Has the program select what is marked. */
function ask() {
  if (socket.readyState > WebSocket.OPEN) {
    update();
    return sayGone();
  }
  asked = true;
  clearHint();
  for (const view of data.views) view.mask = null;
  chosen = marks.length ? SELECTION : 0;
  element('selection').textContent = marks.length ? 'Selecting…' : '';
  fail('');
  update();
  send({select: {marks, camera: data.views[at].camera}});
}

/** Takes marks over that were made in another page, or before this one was loaded, and are not written yet. */
function takeOver(others) {
  if (asked) return;
  marks = others;
  if (!busy) return ask();
  chosen = SELECTION;
  update();
}

function undo() {
  undone.push(marks.pop());
  ask();
}

function redo() {
  marks.push(undone.pop());
  ask();
}
