// The solver's module and its one session.  The functions here also run in a worker, which is made from their text, so
// they refer to nothing outside themselves.

/**
 * A host of the WebAssembly module.  `handle` takes a request and returns its answer:
 *  {module: bytes};
 *  {body: {numbers [11], metres, position, volume, mass, young, poisson, material, materials, links}}, arrays [N, 3] or
 *    [N] in SI units, `metres` those of a scene unit, `material` which of the rows of `materials` [K, 15], links [L, 2]
 *    of what hangs together (empty: all that shares a cell);
 *  {start: {x, v, F, memory, held}}: positions (m), velocities (m/s), gradients (rows), what the law remembers (empty:
 *    nothing), numbers of what acts from the start (and the frame of the recording that they are of, for other
 *    solvers);
 *  {step: {commands, frames}}: commands in order, then frames.  Answers {positions (scene units), velocities (m/s),
 *    gradients, substeps, ms (of a frame), forces [[number, x, y, z]] (N), holds [[number, x, y, z]] (m), failed}.
 * Commands: ['begin', number, numbers], ['move', number, x, y, z], ['drag', number, x, y, z] (by how much the hand has
 * moved since it took hold), ['end', number], ['set', young_scale, damping_time, gx, gy, gz].  The sender numbers
 * interactions; held ones have 0, 1, ...  Where the solver fails, a new instance goes on from the last good frame
 * without what was begun and with the settings of the body, and `failed` says why; where it fails there too, from that
 * frame without velocities, and else from the start without velocities.
 */
export function createSolverHost() {
  const kGrab = 4, kMaterialNumbers = 15;
  let compiled = null, solver = null, body = null, count = 0;
  let good = null;         // {x, v, F, memory} of the last frame
  let first = null;        // and of the start
  let held = new Map();    // number -> numbers, of what acts from the start and has not been ended
  let heldAsCaptured = -1;  // whether a pin held the body as it was captured, 1 or 0; -1: the first instance finds out
  let active = new Map();  // number -> {number in the session, hold point}

  const view = (Type, at, length) => new Type(solver.memory.buffer, at, length);

  function instantiate() {
    const word = (at) => new DataView(solver.memory.buffer, at);
    const wasi = {
      environ_get: () => 0,
      environ_sizes_get: (number, size) => {
        word(number).setUint32(0, 0, true);
        word(size).setUint32(0, 0, true);
        return 0;
      },
      clock_time_get: (clock, precision, at) => {
        word(at).setBigUint64(0, BigInt(Math.round(1e6 * performance.now())), true);
        return 0;
      },
      fd_close: () => 0,
      fd_seek: () => 0,
      fd_write: (file, parts, number, written) => {
        let bytes = 0;
        for (let k = 0; k < number; ++k) bytes += word(parts + 8 * k + 4).getUint32(0, true);
        word(written).setUint32(0, bytes, true);
        return 0;
      },
      proc_exit: () => {
        throw new Error('the solver stopped');
      },
    };
    const page = {
      fail: (at) => {
        const bytes = new Uint8Array(solver.memory.buffer, at);
        throw new Error(new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0))));
      },
    };
    solver = null;
    solver = new WebAssembly.Instance(compiled, {page, wasi_snapshot_preview1: wasi}).exports;
    solver._initialize();
  }

  /** Calls with copies of the arrays in the module's memory. */
  function call(name, before, arrays) {
    const places = arrays.map((array) => {
      const at = solver.solver_allocate(Math.max(array.byteLength, 8));
      view(array.constructor, at, array.length).set(array);
      return at;
    });
    const result = solver[name](...before, ...places);
    for (const at of places) solver.solver_free(at);
    return result;
  }

  function triple(name, number) {
    const at = solver.solver_allocate(24);
    solver[name](number, at);
    const values = [...view(Float64Array, at, 3)];
    solver.solver_free(at);
    return values;
  }

  function open() {
    const {numbers, position, volume, mass, young, poisson, material, materials, links} = body;
    call('solver_body', [count, materials.length / kMaterialNumbers],
        [Float64Array.from(numbers), materials, material, position, volume, mass, young, poisson]);
    call('solver_link', [links.length / 2], [links]);
    active = new Map();
    for (const [number, numbers] of held) {
      call('solver_hold', [], [Float64Array.from(numbers)]);
      active.set(number, {inSession: active.size});
    }
    heldAsCaptured = call('solver_start', [heldAsCaptured, good.memory.length], [good.x, good.v, good.F, good.memory]);
  }

  function keep() {
    const read = (name, size) => view(Float32Array, solver[name](), size).slice();
    const state = {
      x: read('solver_positions', 3 * count), v: read('solver_velocities', 3 * count),
      F: read('solver_gradients', 9 * count), memory: read('solver_memory', good.memory.length),
    };
    let sum = 0;
    for (let i = 0; i < state.x.length; ++i) sum += state.x[i];
    for (let i = 0; i < state.F.length; ++i) sum += state.F[i];
    if (!Number.isFinite(sum)) throw new Error('the motion is not finite');
    good = state;
  }

  /** One frame; its substeps. */
  function advance() {
    const substeps = solver.solver_advance();
    keep();
    return substeps;
  }

  const commands = {
    begin(number, numbers) {
      const inSession = call('solver_begin', [], [Float64Array.from(numbers)]);
      const hold = numbers[0] === kGrab ? triple('solver_hold_point', inSession) : null;
      active.set(number, {inSession, hold});
      return hold && [number, ...hold];
    },
    move(number, x, y, z) {
      const it = active.get(number);
      if (it) solver.solver_move(it.inSession, x, y, z);
    },
    drag(number, x, y, z) {
      const it = active.get(number);
      if (it?.hold) solver.solver_move(it.inSession, it.hold[0] + x, it.hold[1] + y, it.hold[2] + z);
    },
    end(number) {
      const it = active.get(number);
      if (it) solver.solver_end(it.inSession);
      active.delete(number);
      held.delete(number);
    },
    set(...settings) {
      solver.solver_set(...settings);
    },
  };

  /** One frame with a new instance, from the first of these states with which it works; its substeps. */
  function recover() {
    const rest = ({x, F, memory}) => ({x, v: new Float32Array(x.length), F, memory});
    const states = [good, rest(good), rest(first)];
    for (const [attempt, state] of states.entries()) {
      instantiate();
      good = state;
      try {
        open();
        return advance();
      } catch (error) {
        if (attempt === states.length - 1) throw error;
      }
    }
  }

  function step({commands: script, frames}) {
    const answer = {substeps: 0, ms: 0, holds: [], failed: null};
    try {
      for (const [name, ...rest] of script) {
        const hold = commands[name](...rest);
        if (hold) answer.holds.push(hold);
      }
      const start = performance.now();
      for (let f = 0; f < frames; ++f) {
        answer.substeps = advance();
      }
      if (frames > 0) answer.ms = (performance.now() - start) / frames;
    } catch (error) {
      answer.failed = error.message;
      answer.substeps = recover();
    }
    answer.forces = [...active].map(([number, {inSession}]) => [number, ...triple('solver_force', inSession)]);
    answer.positions = good.x.map((value) => value / body.metres);
    answer.velocities = good.v.slice();
    answer.gradients = good.F.slice();
    return answer;
  }

  const requests = {
    module: (bytes) => {
      compiled = new WebAssembly.Module(bytes);
      instantiate();
      return {};
    },
    body: (next) => {
      body = next;
      count = body.mass.length;
      return {};
    },
    start: ({x, v, F, memory, held: numbers}) => {
      first = good = {x, v, F, memory};
      held = new Map(numbers.map((row, number) => [number, row]));
      heldAsCaptured = -1;
      try {
        open();
      } catch (error) {
        instantiate();
        throw error;
      }
      return {};
    },
    step,
  };

  return {
    handle(request) {
      const [name, value] = Object.entries(request)[0];
      return requests[name](value);
    },
  };
}

/** Serves requests {id, request} that come to the scope of a worker; answers {id, answer} or {id, error}. */
export function serveSolver(scope, host) {
  scope.onmessage = ({data: {id, request}}) => {
    try {
      const answer = host.handle(request);
      const arrays = Object.values(answer).filter((value) => value instanceof Float32Array);
      scope.postMessage({id, answer}, arrays.map(({buffer}) => buffer));
    } catch (error) {
      scope.postMessage({id, error: String(error?.message ?? error)});
    }
  };
  scope.postMessage({ready: true});
}
