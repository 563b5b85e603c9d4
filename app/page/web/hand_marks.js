// What the overlay shows of hands and pins.

import {quantity} from './overlay.js';
import {project} from './picking.js';
import {kRegion, regionContains} from './solver_layout.js';
import {forEachWithin} from './tools.js';

const kLeastLine = 4;  // px

/** Centre of mass of drivers (numbers) now, in scene units; null where there are none. */
function centreOf(drivers, positions, mass) {
  const sum = [0, 0, 0];
  let total = 0;
  for (const m of drivers) {
    for (let c = 0; c < 3; ++c) sum[c] += mass[m] * positions[3 * m + c];
    total += mass[m];
  }
  return total > 0 ? sum.map((value) => value / total) : null;
}

/** Draws and says what the hand does. */
export class HandMarks {
  constructor(physics, overlay) {
    this.physics = physics;
    this.overlay = overlay;
    this.touched = {hand: null, drivers: []};
    this.pins = new Map();  // numbers of pins of a session -> drivers
    this.session = 0;       // of LiveMotion
  }

  refresh() {
    const {physics: {hand, running, viewer}} = this;
    const marks = [];
    if (running) {
      const view = viewer.pageView();
      if (hand.tool === 'pin') this.#showPins(view, marks);
      if (hand.held) this.#shows[hand.held.tool]?.(hand.held, view, marks);
    }
    this.overlay.show(marks);
  }

  #shows = {
    grab: (...what) => this.#showGrab(...what), poke: (...what) => this.#showPoke(...what),
    push: (...what) => this.#showPush(...what), wind: (...what) => this.#showWind(...what),
  };

  #showGrab(held, view, marks) {
    const {body, now} = this.physics.live;
    if (this.touched.hand !== held) {
      this.touched = {hand: held, drivers: []};
      forEachWithin(body, held.rest, held.radius, (m) => this.touched.drivers.push(m));
    }
    const hold = centreOf(this.touched.drivers, now.positions, body.material.mass) ?? held.place;
    held.hold ??= hold;
    const target = held.hold.map((value, c) => value + held.target[c] - held.origin[c]);
    this.#line(project(view, hold), project(view, target), this.#force(held), marks);
  }

  #showPoke(held, view, marks) {
    const at = project(view, held.finger), radius = held.radius / this.physics.live.body.metres * view.fx / at.depth;
    marks.push({kind: 'ring', className: 'finger', cx: at.x, cy: at.y, r: Math.abs(radius)});
    this.#label(at, this.#force(held), marks);
  }

  #showPush(held, view, marks) {
    const {clicked, impulse} = this.physics.hand.aim(held), size = Math.hypot(...impulse);
    const from = project(view, held.place);
    const to = clicked ? from : project(view, held.place.map((value, c) => value + held.target[c] - held.origin[c]));
    this.#line(from, to, clicked ? 'Release to push away from you' : quantity(size, 'N·s'), marks);
  }

  #showWind(held, view, marks) {
    this.#line({x: held.startX, y: held.startY}, held, `Wind ${held.speed} m/s`, marks);
  }

  #force({number}) {
    const force = this.physics.forces.get(number);
    return force ? quantity(Math.hypot(...force), 'N') : '';
  }

  #line(from, to, text, marks) {
    const ends = {x1: from.x, y1: from.y, x2: to.x, y2: to.y};
    if (Math.hypot(to.x - from.x, to.y - from.y) > kLeastLine) {
      marks.push({kind: 'line', className: 'line-edge', ...ends}, {kind: 'line', ...ends});
    }
    marks.push({kind: 'dot', cx: from.x, cy: from.y, r: 4}, {kind: 'ring', cx: to.x, cy: to.y, r: 9});
    this.#label(to, text, marks);
  }

  #label({x, y}, text, marks) {
    if (!text) return;
    const {clientWidth: width} = this.overlay.svg, right = x < width - 110;
    marks.push({kind: 'label', className: right ? 'label' : 'before', x: right ? x + 16 : x - 16, y: y - 12, text});
    this.overlay.say(text);
  }

  #showPins(view, marks) {
    const {live: {body, now, session}, hand} = this.physics;
    if (this.session !== session) this.pins.clear();
    this.session = session;
    for (const pin of hand.pins) {
      if (!this.pins.has(pin.number)) this.pins.set(pin.number, driversIn(pin, body));
      const centre = centreOf(this.pins.get(pin.number), now.positions, body.material.mass);
      if (!centre) continue;
      const at = project(view, centre), radius = pin.region === kRegion.sphere ? pin.radius / body.metres : 0;
      marks.push({kind: 'ring', className: 'pin', cx: at.x, cy: at.y, r: Math.max(7, radius * view.fx / at.depth)},
          {kind: 'dot', className: 'pin-dot', cx: at.x, cy: at.y, r: 4});
    }
  }
}

function driversIn(region, {level: {rest, count}, metres}) {
  const inside = [];
  for (let m = 0; m < count; ++m) {
    const place = [0, 1, 2].map((c) => rest[3 * m + c] * metres);
    if (regionContains(region, place)) inside.push(m);
  }
  return inside;
}
