// Camera by mouse, pen and fingers: drag to turn, second button or Shift to move, wheel or pinch to zoom.

const kTurn = 0.006;            // radians per CSS pixel
const kWheel = {0: 0.0015, 1: 0.04, 2: 0.5};  // by unit of the wheel: pixels, lines, pages
const kPinch = 0.01;            // by pixel of a wheel event that stands for a pinch on a trackpad

function midpoint([a, b]) {
  return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, span: Math.hypot(a.x - b.x, a.y - b.y)};
}

/**
 * Connects the element's pointers with the camera.  `claim(event, take)` is true for pointers that serve another tool;
 * `take(id, place)` gives an earlier one of them to the camera, at its place {x, y} in the window.
 */
export function connectGestures(element, camera, claim = () => false) {
  const pointers = new Map();
  const pan = (x, y) => {  // by CSS pixels
    const height = camera.clip.height * camera.scaleIn(element.clientWidth, element.clientHeight);
    camera.pan(-x / height, -y / height);
  };

  element.addEventListener('pointerdown', (event) => {
    if (claim(event, (id, place) => pointers.set(id, place))) return;
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
  });
  element.addEventListener('pointermove', (event) => {
    const old = pointers.get(event.pointerId);
    if (!old) return;
    const now = {x: event.clientX, y: event.clientY};
    if (pointers.size === 1) {
      const x = now.x - old.x, y = now.y - old.y;
      if (event.buttons & 6 || event.shiftKey) pan(x, y);
      else camera.turn(-kTurn * x, kTurn * y);
      pointers.set(event.pointerId, now);
    } else {
      const before = midpoint([...pointers.values()]);
      pointers.set(event.pointerId, now);
      const after = midpoint([...pointers.values()]);
      pan(after.x - before.x, after.y - before.y);
      if (before.span > 0 && after.span > 0) camera.zoom(before.span / after.span);
    }
  });
  for (const type of ['pointerup', 'pointercancel', 'lostpointercapture']) {
    element.addEventListener(type, (event) => pointers.delete(event.pointerId));
  }
  element.addEventListener('wheel', (event) => {
    event.preventDefault();
    const pinch = event.ctrlKey && event.deltaMode === 0, factor = pinch ? kPinch : kWheel[event.deltaMode];
    camera.zoom(Math.exp(Math.min(0.5, Math.max(-0.5, event.deltaY * factor))));
  }, {passive: false});
  // Safari tells of a trackpad's pinch by events of its own; fingers on a screen are pointers already.
  let scale = 1;
  element.addEventListener('gesturestart', (event) => {
    event.preventDefault();
    scale = 1;
  });
  element.addEventListener('gesturechange', (event) => {
    event.preventDefault();
    if (!pointers.size) camera.zoom(scale / event.scale);
    scale = event.scale;
  });
  element.addEventListener('contextmenu', (event) => event.preventDefault());
}
