// What the program says, and what it is asked for besides a selection.  The last of the script: the page is ready.

const socket = new WebSocket(new URL('live', location.href).href.replace(/^http/, 'ws'));
/** Sends a message as soon as the connection is there. */
function send(message) {
  const text = JSON.stringify(message);
  if (socket.readyState === WebSocket.CONNECTING)
    socket.addEventListener('open', () => socket.send(text), {once: true});
  else
    socket.send(text);
}
const says = {find: 'Finding objects', make: 'Preparing the object', name: 'Naming'};
function fail(text) {
  element('failed').textContent = text;
  element('failed').hidden = !text;
}
socket.onmessage = ({data: text}) => {
  const message = JSON.parse(text);
  if ('busy' in message) {
    busy = message.busy;
    if (busy) fail('');
    element('doing').textContent = says[busy] ?? '';
    element('progress').value = 0;
    update();
  }
  if (message.marks) takeOver(message.marks);
  if (message.selected && chosen === SELECTION) {
    const {gaussians, seconds} = message.selected;
    element('selection').textContent = `${gaussians.toLocaleString('en')} Gaussians selected in ${seconds.toFixed(2)} s`;
  }
  if (message.mask && chosen === SELECTION) {
    viewOf(message.mask.camera).mask = layerOf(message.mask, [64, 160, 255, 130]);
    draw();
  }
  if (message.hover && tool === 'click') {
    const view = viewOf(message.hover.camera);
    if (view === data.views[at]) view.hint = layerOf(message.hover, [255, 213, 74, 90]);
    draw();
  }
  if (message.kept) {
    const before = names.get(chosen);
    data.things = message.kept.things;
    names = new Map(data.things.map((thing) => [thing.id, thing]));
    if (chosen > 0 && names.get(chosen)?.gaussians !== before?.gaussians) chosen = 0;  // another object has its id
    for (const {camera, ids} of message.kept.views) fillIds(viewOf(camera), ids);
    listThings();
    update();
  }
  if (message.progress) {
    element('doing').textContent = `${says[busy] ?? 'Working'}: ${message.progress.text}`;
    element('progress').value = message.progress.fraction;
  }
  if (message.said) element('said').textContent = (message.warning ? 'Warning: ' : '') + message.said;
  if (message.failed || message.error) {
    fail(message.failed ?? message.error);
    element('selection').textContent = '';
  }
  if (message.reload) location.reload();
};
function sayGone() {
  element('selection').textContent = '';
  fail('The connection to the program has ended. Reload this page. If it does not load, start pliant view again.');
}
socket.onclose = sayGone;
element('find').onclick = () => send({find: true});
element('make').onclick = () => send({make: {object: Math.max(chosen, 0), label: element('label').value.trim()}});
element('naming').onsubmit = (event) => {
  event.preventDefault();
  const name = element('name').value.trim();
  if (name) send({name: {object: Math.max(chosen, 0), name}});
};
element('cancel').onclick = () => send({cancel: true});
update();
