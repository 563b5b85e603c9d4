// What a pointer, or the keys in its place, does in the picture: it takes objects and draws marks.

const LEAST_STEP = 3;  // px between the points of a line, and of the sides of a box
const LEAST_BOX = 4;  // px of the camera, of the sides of a box; see add_box of gesture_prompts.cpp
const MOST_POINTS = 1000;  // of a mark; see kLongestMark of choose_request.cpp
let pointer = null;  // id of the one that draws the line; null = the keys do

/** Place of the pointer in the pixels of the view; null outside the picture. */
function placeOf(event) {
  const view = data.views[at], box = canvas.getBoundingClientRect();
  const scale = Math.min(box.width / view.width, box.height / view.height);
  const x = (event.clientX - box.left - (box.width - scale * view.width) / 2) / scale;
  const y = (event.clientY - box.top - (box.height - scale * view.height) / 2) / scale;
  return x >= 0 && y >= 0 && x < view.width && y < view.height ? [x, y] : null;
}

/** Has the program guess what a click would select, when the pointer rests. */
function hover(place) {
  clearTimeout(hoverAt);
  clearHint();
  hoverAt = setTimeout(() => send({hover: [data.views[at].camera, ...textOf(place).split(',').map(Number)]}), 120);
}

canvas.onpointermove = (event) => {
  const place = placeOf(event), view = data.views[at];
  if (line) {
    if (event.pointerId !== pointer) return;
    if (place && Math.hypot(place[0] - line.at(-1)[0], place[1] - line.at(-1)[1]) >= LEAST_STEP) line.push(place);
    return draw();
  }
  if (place && tool === 'click' && !busy) hover(place);
  const id = place && tool === 'take' ? view.id[Math.floor(place[1]) * view.width + Math.floor(place[0])] : 0;
  if (id === over) return;
  over = id;
  draw();
};
canvas.onpointerleave = () => {
  over = 0;
  clearTimeout(hoverAt);
  clearHint();
  draw();
};
/** What the tool does at a place: takes it, marks it, or begins a box or line. */
function begin(place) {
  const view = data.views[at];
  clearTimeout(hoverAt);
  if (tool === 'take') {
    const id = view.id[Math.floor(place[1]) * view.width + Math.floor(place[0])];
    if (id) choose(id);
  } else if (tool === 'click') {
    addMarks([{kind: 'click', text: `${view.camera},${textOf(place)}`}]);
  } else {
    line = [place];
  }
}

/** A line in pieces that each fit into a mark; each begins where the one before ends. */
function piecesOf(points) {
  const out = [];
  for (let k = 0; k === 0 || k < points.length - 1; k += MOST_POINTS - 1) out.push(points.slice(k, k + MOST_POINTS));
  return out;
}

function finish() {
  const points = line, camera = data.views[at].camera;
  line = null;
  if (tool !== 'box' && points.length === 1) points.push(points[0]);  // a dot
  if (tool !== 'box') {
    const strokeOf = (piece) => `${tool},${camera},${piece.map(textOf).join(',')}`;
    return addMarks(piecesOf(points).map((piece) => ({kind: 'stroke', text: strokeOf(piece)})));
  }
  const [x0, y0] = points[0], [x1, y1] = points.at(-1);
  if (Math.abs(x1 - x0) < LEAST_STEP || Math.abs(y1 - y0) < LEAST_STEP) return draw();
  const corners = [[Math.min(x0, x1), Math.min(y0, y1)], [Math.max(x0, x1), Math.max(y0, y1)]].map(textOf);
  // As the program reads them, in single precision.
  const [low, high] = corners.map((text) => text.split(',').map((number) => Math.fround(number)));
  if (low.some((x, axis) => Math.fround(high[axis] - x) < LEAST_BOX)) return draw();
  addMarks([{kind: 'box', text: `${camera},${corners.join(',')}`}]);
}

canvas.onpointerdown = (event) => {
  const place = placeOf(event);
  if (!place || busy || event.button || !event.isPrimary || (line && pointer !== null)) return;
  cross = null;
  pointer = event.pointerId;
  begin(place);
  if (line) canvas.setPointerCapture(event.pointerId);
};
canvas.onpointerup = (event) => {
  if (!line || event.pointerId !== pointer) return;
  line.push(placeOf(event) ?? line.at(-1));
  finish();
};
canvas.onpointercancel = (event) => {
  if (line && event.pointerId === pointer) finish();
};
const steps = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
canvas.onkeydown = (event) => {
  const view = data.views[at];
  if (event.key === 'PageUp') turn(-1);
  else if (event.key === 'PageDown') turn(1);
  else if (event.key in steps) {
    const by = event.shiftKey ? 2 : 16;
    const [x, y] = cross ?? [view.width / 2, view.height / 2], [dx, dy] = steps[event.key];
    cross = [Math.min(Math.max(x + by * dx, 0), view.width - 1), Math.min(Math.max(y + by * dy, 0), view.height - 1)];
    if (line) line.push(cross);
    else if (tool === 'click' && !busy) hover(cross);
    over = tool === 'take' ? view.id[Math.floor(cross[1]) * view.width + Math.floor(cross[0])] : 0;
    draw();
  } else if ((event.key === 'Enter' || event.key === ' ') && !busy) {
    cross ??= [view.width / 2, view.height / 2];
    if (line) {
      finish();
    } else {
      pointer = null;
      begin(cross);
    }
    draw();
  } else if (event.key === 'Escape' && line) {
    line = null;
    draw();
  } else {
    return;
  }
  event.preventDefault();
};
canvas.onfocus = canvas.onblur = () => draw();
