// The object as bodies for the solver, one per level of detail, and their states in the recording.

import {Carrier, kNeighbours} from './carry.js';
import {ClipError} from './container.js';
import {readLevel} from './motion.js';
import {bodyNumbers} from './solver_layout.js';

const kMaterialNumbers = 15;  // see app/page/material_numbers.h
const kMemoryNumbers = 19;    // of a driver, see solver_memory

/** A body of the solver: the drivers of a level with their material. */
export class Body {
  /**
   * `recorded`: {level, source} of the baked motion (see BakedMotion); the body may be of another level, whose drivers
   * `binding` binds to those of the motion (see Carrier).
   */
  constructor(header, level, material, recorded, binding) {
    this.level = level;
    this.count = level.count;
    this.material = material;
    this.recorded = recorded;
    this.binding = binding;
    this.metres = header.metres_per_unit;
    this.fps = header.solver.fps;
    this.clusteredTo = header.levels[level.index].clustered_to;  // 0: the particles of the simulation
    this.cellSize = header.levels[level.index].cell_size;  // m
    this.numbers = bodyNumbers(header.solver, this.cellSize);
  }

  /** The request that tells the solver about the body. */
  get request() {
    const position = this.level.rest.map((value) => value * this.metres);
    return {body: {numbers: this.numbers, metres: this.metres, position, ...this.material}};
  }

  /** Drivers of this level in the recording at a frame, in new arrays: {positions, gradients}. */
  at(frame) {
    const {source} = this.recorded, drivers = source.frameAt(frame, source.arrays());
    if (this.level === this.recorded.level) return drivers;
    this.carrier ??= new Carrier(this.level.rest, this.recorded.level.rest, this.binding);
    return this.carrier.carry(drivers);
  }

  /** Velocities [M, 3] (m/s) in the recording at a frame: central differences, one-sided at its ends. */
  velocitiesAt(frame, framesPerSecond) {
    const before = Math.max(frame - 1, 0), after = Math.min(frame + 1, this.recorded.source.frames - 1);
    if (!(after > before)) return new Float32Array(3 * this.count);
    const early = this.at(before).positions, scale = this.metres * framesPerSecond / (after - before);
    return this.at(after).positions.map((value, i) => scale * (value - early[i]));
  }
}

function readMaterial(container, index, {drivers: count, links: pairs, materials: kinds}, remembers) {
  const array = (name, ...shape) => container.array(`level${index}.${name}`, shape).values.slice();
  const read = (name) => array(name, count);
  const steps = container.array(`level${index}.links`, [pairs, 2]).values, links = new Int32Array(2 * pairs);
  for (let k = 0, first = 0; k < links.length; k += 2) {
    links[k] = first += steps[k];
    links[k + 1] = first + steps[k + 1];
    if (links[k + 1] >= count) throw new ClipError(`The data in this file are inconsistent (level${index}.links).`);
  }
  const material = read('material');
  if (material.some((k) => k >= kinds)) {
    throw new ClipError(`The data in this file are inconsistent (level${index}.material).`);
  }
  return {
    volume: read('volume'), mass: read('mass'), young: read('young'), poisson: read('poisson'), links, material,
    materials: array('materials', kinds, kMaterialNumbers),
    memory: remembers ? array('memory', kMemoryNumbers * count) : new Float32Array(0),
  };
}

/** What carries the drivers of a level: those of the motion, which has `others`. */
function readBinding(container, index, count, others) {
  const read = (name) => container.array(`level${index}.from.${name}`, [count, kNeighbours]).values.slice();
  const driver = read('driver'), weight = read('weight');
  if (driver.some((m, k) => weight[k] > 0 && m >= others)) {
    throw new ClipError(`The data in this file are inconsistent (level${index}.from).`);
  }
  return {driver, weight};
}

/** Bodies of all levels of the inflated section `levels`, the finest first. */
export function readBodies(container, header, object, recorded) {
  return header.levels.map((description, index) => {
    const material = readMaterial(container, index, description, header.solver.remembers);
    if (index === recorded.level.index) return new Body(header, recorded.level, material, recorded, null);
    const level = readLevel(container, index, description, object.count, object.rows);
    const binding = readBinding(container, index, level.count, recorded.level.count);
    return new Body(header, level, material, recorded, binding);
  });
}
