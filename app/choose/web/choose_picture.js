// The views of the scene, and what is drawn over the one that is shown.

/** The id of every pixel of a view from its run lengths. */
function fillIds(view, runs) {
  view.id = new Uint32Array(view.width * view.height);
  for (let k = 0, p = 0; k < runs.length; k += 2) {
    view.id.fill(runs[k], p, p + runs[k + 1]);
    p += runs[k + 1];
  }
}

for (const view of data.views) {
  fillIds(view, view.ids);
  view.image = new Image();
  view.image.onload = draw;
  view.image.src = 'data:image/webp;base64,' + view.picture;
}

const canvas = element('picture'), context = canvas.getContext('2d');

function tint(view) {
  const layer = new ImageData(view.width, view.height);
  const strength = new Map();
  for (const id of [over, chosen]) if (id) strength.set(id, id === chosen ? 140 : 80);
  for (let p = 0; p < view.id.length; ++p) {
    const alpha = strength.get(view.id[p]);
    if (!alpha) continue;
    const [r, g, b] = names.get(view.id[p])?.color ?? [1, 1, 1];
    layer.data.set([255 * r, 255 * g, 255 * b, alpha], 4 * p);
  }
  return sheetOf(layer);
}

function sheetOf(layer) {
  const sheet = new OffscreenCanvas(layer.width, layer.height);
  sheet.getContext('2d').putImageData(layer, 0, 0);
  return sheet;
}

/** A picture of a mask that the program sent: run lengths of 0 and 1. */
function layerOf({width, height, runs}, [r, g, b, alpha]) {
  const layer = new ImageData(width, height);
  for (let k = 0, p = 0; k < runs.length; p += runs[k + 1], k += 2)
    if (runs[k]) for (let i = p; i < p + runs[k + 1]; ++i) layer.data.set([r, g, b, alpha], 4 * i);
  return sheetOf(layer);
}
const viewOf = (camera) => data.views.find((view) => view.camera === camera);

function drawLine(points, added) {
  context.strokeStyle = context.fillStyle = added ? '#35d07f' : '#ff5c5c';
  context.lineWidth = 8 / data.views[at].scale[0];
  context.lineCap = context.lineJoin = 'round';
  context.beginPath();
  points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
  if (points.every(([x, y]) => x === points[0][0] && y === points[0][1])) {
    context.beginPath();
    context.arc(points[0][0], points[0][1], 5, 0, 7);
    context.fill();
  }
}

function drawBox([[x0, y0], [x1, y1]]) {
  context.strokeStyle = '#ffd54a';
  context.lineWidth = 2;
  context.strokeRect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
}

function draw() {
  const view = data.views[at];
  if (!view) return;
  canvas.width = view.width;
  canvas.height = view.height;
  context.drawImage(view.image, 0, 0);
  if (chosen !== SELECTION || tool === 'take') context.drawImage(tint(view), 0, 0);
  if (chosen === SELECTION && view.mask) context.drawImage(view.mask, 0, 0);
  if (view.hint) context.drawImage(view.hint, 0, 0, view.width, view.height);
  for (const mark of currentMarks()) {
    const points = pointsIn(mark, view);
    if (points.length === 0) continue;
    if (mark.kind === 'box')
      drawBox(points);
    else
      drawLine(points, !mark.text.startsWith('bg'));
  }
  if (line && tool === 'box')
    drawBox([line[0], line.at(-1)]);
  else if (line)
    drawLine(line, tool === 'fg');
  if (cross && document.activeElement === canvas) {
    context.strokeStyle = '#ffd54a';
    context.lineWidth = 2;
    context.strokeRect(cross[0] - 6, cross[1] - 6, 12, 12);
  }
  const named = names.get(over || chosen);
  element('caption').textContent = `${view.name} (${at + 1} of ${data.views.length})` + (named ? `: ${named.name}` : '');
}

function turn(by) {
  clearHint();
  cross = line = null;
  at = (at + by + data.views.length) % data.views.length;
  draw();
}
element('previous').onclick = () => turn(-1);
element('next').onclick = () => turn(1);

function clearHint() {
  for (const view of data.views) view.hint = null;
}
