// The hand on the picture by mouse, pen, finger or keys.

import {pick, project} from './picking.js';

const kReach = {mouse: 18, pen: 18, touch: 32};  // px around the pointer in which the object is found
const kFarReach = 200;                           // px around the object's centre, for keys
const kStep = 16;                                // px of an arrow key
const kLift = 0.02;                              // of the depth: Page Up and Page Down

/**
 * Connects the canvas with the hand; `claim(event, take)` is for connectGestures, `key(event)` true for keys that it
 * has used.
 */
export class HandInput {
  constructor(physics, canvas) {
    this.physics = physics;
    this.canvas = canvas;
    this.pointer = null;  // id of the pointer that holds the object
    this.place = null;    // of that pointer in the window
    this.byKeys = false;
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    for (const type of ['pointerup', 'pointercancel', 'lostpointercapture']) {
      canvas.addEventListener(type, (event) => {
        if (event.pointerId === this.pointer) this.release(type === 'pointercancel');
      });
    }
    canvas.addEventListener('pointerleave', () => canvas.removeAttribute('data-over'));
  }

  claim(event, take) {
    const {hand} = this.physics;
    if (event.pointerType === 'touch' && !event.isPrimary) {  // two fingers are the camera's
      const {pointer, place} = this;
      if (pointer !== null) {
        this.release(true);
        take(pointer, place);
      }
      return false;
    }
    if (hand.held || event.button || event.shiftKey || event.ctrlKey) return false;
    const {x, y} = this.#place(event);
    if (!this.#begin(x, y, kReach[event.pointerType] ?? kReach.mouse)) return false;
    this.pointer = event.pointerId;
    this.place = {x: event.clientX, y: event.clientY};
    this.canvas.setPointerCapture(event.pointerId);
    return true;
  }

  /** Takes hold of the object at its centre, or lets go. */
  toggle() {
    if (this.physics.hand.held) {
      this.release();
      return;
    }
    const view = this.physics.viewer.pageView(), at = project(view, this.#centre());
    if (!this.#begin(at.x, at.y, kFarReach)) return;
    this.byKeys = true;
    if (this.physics.hand.held.tool === 'pin') this.release();
  }

  /** Lets go; a push or pin that is `cancelled` is not made. */
  release(cancelled = false) {
    const {hand, viewer} = this.physics;
    this.pointer = null;
    this.byKeys = false;
    // The pointer may have moved since the last picture, and the way of a push is that of the hand up to now.
    if (hand.held?.tool === 'push') hand.update(viewer.pageView());
    if (cancelled && ['push', 'pin'].includes(hand.held?.tool)) hand.drop();
    else hand.end();
    viewer.dirty = true;
  }

  /** While the hand holds by keys: arrows move it, Page Up and Page Down too, Escape and Enter let go. */
  key({key}) {
    const {hand} = this.physics;
    if (!this.byKeys || !hand.held) return false;
    const {x, y, origin} = hand.held, depth = project(this.physics.viewer.pageView(), origin).depth;
    const keys = {
      ArrowLeft: [-kStep, 0, 0], ArrowRight: [kStep, 0, 0], ArrowUp: [0, -kStep, 0], ArrowDown: [0, kStep, 0],
      PageUp: [0, 0, -kLift * depth], PageDown: [0, 0, kLift * depth],
    };
    if (key === 'Escape' || key === 'Enter') {
      this.release();
    } else if (keys[key]) {
      const [dx, dy, lift] = keys[key];
      hand.move(x + dx, y + dy, lift);
      this.physics.viewer.dirty = true;
    } else {
      return false;
    }
    return true;
  }

  #begin(x, y, reach) {
    const {physics} = this, {viewer} = physics, view = viewer.pageView();
    const found = viewer.centres && pick(view, viewer.centres, physics.movable, x, y, reach);
    if (!found) return false;
    const elsewhere = physics.enter();
    physics.live.manual = false;
    // A finger comes from in front of the surface that it is to touch, which is not where it was picked.
    if (elsewhere && physics.hand.tool === 'poke') return false;
    const rest = physics.restOf(found.index);
    physics.hand.begin(view, x, y, found, rest);
    viewer.dirty = true;
    return true;
  }

  /** Centre of the object as it is now. */
  #centre() {
    const {positions} = this.physics.viewer.drivers, count = positions.length / 3, sum = [0, 0, 0];
    positions.forEach((value, i) => sum[i % 3] += value);
    return sum.map((value) => value / count);
  }

  #place({clientX, clientY}) {
    const box = this.canvas.getBoundingClientRect();
    return {x: clientX - box.left, y: clientY - box.top};
  }

  #move(event) {
    const {x, y} = this.#place(event), {physics, canvas} = this;
    if (event.pointerId === this.pointer) {
      this.place = {x: event.clientX, y: event.clientY};
      physics.hand.move(x, y);
      physics.viewer.dirty = true;
    } else if (!event.buttons && event.pointerType === 'mouse') {
      this.hover ??= requestAnimationFrame(() => {
        const {viewer, movable} = physics, [at, reach] = [this.hoverPlace, kReach.mouse];
        this.hover = null;
        const over = viewer.centres && pick(viewer.pageView(), viewer.centres, movable, at.x, at.y, reach);
        canvas.toggleAttribute('data-over', Boolean(over));
      });
      this.hoverPlace = {x, y};
    }
  }
}
