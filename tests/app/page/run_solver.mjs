// Runs the solver of clip.html in node: node run_solver.mjs MODULE.wasm CASE.json OUT
// CASE: {solver, cell_size, position, volume, mass, young, poisson, links, materials, material, start, script [{frame, begin [22]} | {frame, move:
// [number, x, y, z]} | {frame, end: number} | {frame, set: [5]}], frames}, `solver` as in the header of a clip.html.
// Writes positions and deformation gradients of every frame as float32 and prints milliseconds and substeps.
// A CASE with `steps`, a list of {commands, frames}, is run by the host of the page instead (see createSolverHost), and
// [{failed, forces}] of each is printed.
// A CASE {carry: {rest, from, driver, weight, positions, gradients}} is carried by carry.js (see Carrier): it
// writes the carried positions and gradients as float32.

import fs from 'node:fs';

const ofPage = (name) => {
  const text = fs.readFileSync(new URL(`../../../app/page/web/${name}`, import.meta.url), 'utf8');
  return import(`data:text/javascript,${encodeURIComponent(text)}`);
};
const {bodyNumbers} = await ofPage('solver_layout.js');
const kMaterialNumbers = 15;
const [wasm, file, out] = process.argv.slice(2);
const text = fs.readFileSync(file, 'utf8'), run = JSON.parse(text), floats = (values) => Float32Array.from(values);
if (run.carry) {
  const {rest, from, driver, weight, positions, gradients} = run.carry, {Carrier} = await ofPage('carry.js');
  const carrier = new Carrier(floats(rest), floats(from), {driver: Uint16Array.from(driver), weight: floats(weight)});
  const carried = carrier.carry({positions: floats(positions), gradients: floats(gradients)});
  const parts = [carried.positions, carried.gradients].map((values) => Buffer.from(values.buffer));
  fs.writeFileSync(out, Buffer.concat(parts));
  console.log('{}');
  process.exit(0);
}
if (run.steps) {
  const host = (await ofPage('solver_host.js')).createSolverHost();
  const {position, volume, mass, young, poisson} = run, {x, v, F, memory} = run.start;
  host.handle({module: fs.readFileSync(wasm)});
  host.handle({body: {
    numbers: bodyNumbers(run.solver, run.cell_size), metres: 1, position: floats(position), volume: floats(volume),
    mass: floats(mass), young: floats(young), poisson: floats(poisson), links: Int32Array.from(run.links),
    materials: Float64Array.from(run.materials), material: Uint16Array.from(run.material),
  }});
  host.handle({start: {
    x: floats(x), v: floats(v), F: floats(F), memory: floats(memory), held: run.solver.held,
  }});
  const answers = run.steps.map((step) => host.handle({step}));
  console.log(JSON.stringify(answers.map(({failed, forces}) => ({failed, forces}))));
  process.exit(0);
}
let memory = null;
const view = () => new DataView(memory.buffer);
const string = pointer => {
  const bytes = new Uint8Array(memory.buffer, pointer);
  return Buffer.from(bytes.subarray(0, bytes.indexOf(0))).toString();
};
const none = (count, size) => {
  view().setUint32(count, 0, true);
  view().setUint32(size, 0, true);
  return 0;
};
const imports = {
  page: {fail: pointer => { throw new Error(string(pointer)); }},
  wasi_snapshot_preview1: {
    environ_get: () => 0, environ_sizes_get: none, fd_close: () => 8, fd_seek: () => 8,
    fd_write: (fd, list, count, written) => (view().setUint32(written, 0, true), 0),
    clock_time_get: (id, precision, time) => (view().setBigUint64(time, 0n, true), 0),
    proc_exit: code => { throw new Error(`the solver ended with code ${code}`); },
  },
};
const {instance} = await WebAssembly.instantiate(fs.readFileSync(wasm), imports), solver = instance.exports;
memory = solver.memory;
solver._initialize();
const put = (values, Type) => {
  const pointer = solver.solver_allocate(values.length * Type.BYTES_PER_ELEMENT);
  new Type(memory.buffer, pointer, values.length).set(values);
  return pointer;
};
const n = run.volume.length;
try {
  solver.solver_body(n, run.materials.length / kMaterialNumbers,
      put(bodyNumbers(run.solver, run.cell_size), Float64Array), put(run.materials, Float64Array),
      put(run.material, Uint16Array), put(run.position, Float32Array), put(run.volume, Float32Array), put(run.mass, Float32Array), put(run.young, Float32Array),
      put(run.poisson, Float32Array));
  solver.solver_link(run.links.length / 2, put(run.links, Int32Array));
  for (const numbers of run.solver.held) solver.solver_hold(put(numbers, Float64Array));
  const {x, v, F, memory: remembered} = run.start;
  solver.solver_start(-1, remembered.length, ...[x, v, F, remembered].map((values) => put(values, Float32Array)));
  const chunks = [];
  let milliseconds = 0, substeps = 0;
  for (let frame = 0; frame < run.frames; ++frame) {
    for (const step of run.script.filter(s => s.frame === frame)) {
      if (step.begin) solver.solver_begin(put(step.begin, Float64Array));
      if (step.move) solver.solver_move(...step.move);
      if (step.end !== undefined) solver.solver_end(step.end);
      if (step.set) solver.solver_set(...step.set);
    }
    const start = performance.now();
    substeps += solver.solver_advance();
    milliseconds += performance.now() - start;
    for (const [pointer, count] of [[solver.solver_positions(), 3 * n], [solver.solver_gradients(), 9 * n]])
      chunks.push(Buffer.from(memory.buffer.slice(pointer, pointer + 4 * count)));
  }
  fs.writeFileSync(out, Buffer.concat(chunks));
  console.log(JSON.stringify({milliseconds, substeps}));
} catch (error) {
  console.log(JSON.stringify({error: error.message}));
}
