// What a hand on the picture does to the object: grab, poke, push, wind, pin.

import {axesOf, unproject} from './picking.js';
import {interactionNumbers, kType, readInteraction, regionContains} from './solver_layout.js';

const kLeastCells = 1.5;     // radius of what a hand touches, in cells
const kApproach = 8;         // frames in which a finger comes in from the front
const kAhead = 1.5;          // radii in front of the surface at which it begins
const kFriction = 0.5;       // of a finger
const kClick = 6;            // px within which a press does not count as a drag
const kClickSpeed = 1.5;     // of a push without a drag: heights of the object per second
const kAimTime = 0.25;       // s in which a push would cover the way of the hand
const kMostSpeed = 6;        // of a push, heights per second
const kWindTurn = 12;        // degrees by which the wind turns at least
const kWindReach = 120;      // px of a drag that turn the wind fully sideways

const add = (a, b, scale = 1) => a.map((value, c) => value + scale * b[c]);
const subtract = (a, b) => a.map((value, c) => value - b[c]);
const times = (a, scale) => a.map((value) => value * scale);
const dot = (a, b) => a.reduce((sum, value, c) => sum + value * b[c], 0);
const lengthOf = (a) => Math.hypot(...a);
const unit = (a) => times(a, 1 / Math.max(lengthOf(a), 1e-12));

/** The tools in order: the key of each is its place, from 1 on. */
export const kTools = ['grab', 'poke', 'push', 'wind', 'pin'];

/** The one hand of a person.  `live` is the LiveMotion; lengths are scene units unless they say otherwise. */
export class Hand {
  constructor(live, objectHeight) {
    this.live = live;
    this.objectHeight = objectHeight;  // m
    this.tool = 'grab';
    this.size = 0.08;       // of the object's height
    this.windSpeed = 5;     // m/s
    this.held = null;       // what the hand is doing
  }

  /** Radius of what the hand touches (m). */
  get radius() {
    return Math.max(this.size * this.objectHeight, kLeastCells * this.live.body.cellSize);
  }

  /** Begins at a pixel of the view, on a Gaussian that was picked there (see pick) and lies at `rest` at rest. */
  begin(view, x, y, picked, rest) {
    const {place, depth} = picked, origin = unproject(view, x, y, depth);
    this.held = {
      tool: this.tool, x, y, startX: x, startY: y, lift: 0, place, origin, target: origin, rest: this.#near(rest),
      radius: this.radius, axes: axesOf(view), number: null,
    };
    this.#tools[this.tool].begin?.(this.held);
    this.update(view);
  }

  /** Takes the hand to a pixel; `lift` moves it towards the camera. */
  move(x, y, lift = 0) {
    if (this.held) Object.assign(this.held, {x, y, lift: this.held.lift + lift});
  }

  /** Passes on where the hand is now. */
  update(view) {
    const hand = this.held;
    if (!hand) return;
    hand.axes = axesOf(view);
    const {forward} = hand.axes, depth = dot(forward, subtract(hand.place, view.centre));
    hand.target = add(unproject(view, hand.x, hand.y, Math.max(depth, 1e-3)), forward, -hand.lift);
    this.#tools[hand.tool].move?.(hand);
  }

  /** Lets go. */
  end() {
    const hand = this.held;
    this.held = null;
    if (hand) this.#tools[hand.tool].end?.(hand);
  }

  /** Forgets what the hand did, because the session is over. */
  drop() {
    this.held = null;
  }

  /** Numbers of the pins now. */
  get pins() {
    return [...this.live.acting].filter(([, numbers]) => numbers[0] === kType.pin)
        .map(([number, numbers]) => ({number, ...readInteraction(numbers)}));
  }

  /** The push that the hand aims at: {velocity (m/s), impulse (N s)}. */
  aim(hand) {
    const {metres} = this.live.body, way = subtract(hand.target, hand.origin), mass = this.#touchedMass(hand);
    const clicked = Math.hypot(hand.x - hand.startX, hand.y - hand.startY) < kClick && !hand.lift;
    const velocity = clicked ? times(hand.axes.forward, kClickSpeed * this.objectHeight)
                             : times(way, metres / kAimTime);
    const most = kMostSpeed * this.objectHeight, limited = Math.min(1, most / Math.max(lengthOf(velocity), 1e-12));
    return {clicked, velocity: times(velocity, limited), impulse: times(velocity, limited * mass)};
  }

  #tools = {
    grab: {
      begin: (hand) => hand.number = this.#start({type: 'grab', centre: hand.rest, radius: hand.radius}),
      move: (hand) => this.#moved(hand, 'drag', subtract(hand.target, hand.origin)),
      end: (hand) => this.live.end(hand.number),
    },
    poke: {
      begin: (hand) => {
        hand.begun = this.live.recording.frames;
        const centre = add(hand.place, hand.axes.forward, -kAhead * hand.radius / this.live.body.metres);
        hand.number = this.#start({type: 'poke', centre, radius: hand.radius, friction: kFriction});
        hand.finger = centre;
      },
      move: (hand) => {
        const ahead = kAhead * Math.max(0, 1 - (this.live.recording.frames - hand.begun + 1) / kApproach);
        hand.finger = add(hand.target, hand.axes.forward, -ahead * hand.radius / this.live.body.metres);
        this.#moved(hand, 'move', hand.finger);
      },
      end: (hand) => this.live.end(hand.number),
    },
    push: {
      end: (hand) => {
        const {impulse} = this.aim(hand);
        this.#start({type: 'impulse', centre: hand.rest, radius: hand.radius, strength: impulse});
      },
    },
    wind: {
      move: (hand) => {
        const {right, down, forward} = hand.axes, x = (hand.x - hand.startX) / kWindReach;
        const y = (hand.y - hand.startY) / kWindReach, ahead = Math.sqrt(Math.max(0, 1 - x * x - y * y));
        const direction = unit(add(add(times(forward, ahead), right, x), down, y));
        const cosine = hand.wind ? dot(direction, hand.wind) : -1;
        if (cosine > Math.cos(kWindTurn * Math.PI / 180) && hand.speed === this.windSpeed) return;
        if (hand.number !== null) this.live.end(hand.number);
        Object.assign(hand, {wind: direction, speed: this.windSpeed});
        hand.number = this.#start({type: 'wind', strength: times(direction, this.windSpeed)});
      },
      end: (hand) => this.live.end(hand.number),
    },
    pin: {
      end: (hand) => {
        const place = times(hand.rest, this.live.body.metres);
        const pins = this.pins.filter((region) => regionContains(region, place));
        for (const {number} of pins) this.live.end(number);
        if (!pins.length) this.#start({type: 'pin', centre: hand.rest, radius: hand.radius});
      },
    },
  };

  /** Begins an interaction; `centre` in scene units, the rest in SI units. */
  #start({centre, ...description}) {
    const {metres} = this.live.body;
    return this.live.start(interactionNumbers({...description, centre: centre && times(centre, metres)}));
  }

  #moved(hand, name, to) {
    if (hand.last?.every((value, c) => value === to[c])) return;
    hand.last = to;
    this.live.move(hand.number, name, times(to, this.live.body.metres));
  }

  /** The driver nearest to a place at rest where none would be touched there, else the place. */
  #near(place) {
    const {level, metres} = this.live.body, {rest} = level;
    let nearest = 0, least = Infinity;
    for (let m = 0; m < level.count; ++m) {
      const d = Math.hypot(rest[3 * m] - place[0], rest[3 * m + 1] - place[1], rest[3 * m + 2] - place[2]);
      if (d < least) [nearest, least] = [m, d];
    }
    return least * metres > 0.7 * this.radius ? [...rest.subarray(3 * nearest, 3 * nearest + 3)] : place;
  }

  /** Mass of what the hand touches (kg). */
  #touchedMass({rest, radius}) {
    let sum = 0;
    forEachWithin(this.live.body, rest, radius, (m) => sum += this.live.body.material.mass[m]);
    return sum;
  }
}

/** Calls `visit(driver)` for the drivers of a body within a radius (m) of a place at rest (scene units). */
export function forEachWithin({level: {rest, count}, metres}, place, radius, visit) {
  for (let m = 0; m < count; ++m) {
    const d = Math.hypot(rest[3 * m] - place[0], rest[3 * m + 1] - place[1], rest[3 * m + 2] - place[2]);
    if (d * metres <= radius) visit(m);
  }
}
