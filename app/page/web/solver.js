// The solver in a worker, or on the main thread where workers are blocked.

import {ClipError} from './container.js';
import {createSolverHost, serveSolver} from './solver_host.js';
import {startWorker} from './start_worker.js';

const kAdvice = 'Reload the page to try again.';

/** Sends requests (see createSolverHost), which are answered in order.  Several may be under way. */
export class Solver {
  /** A solver of the module (bytes, given away).  Throws where WebAssembly is blocked. */
  static async create(bytes) {
    const worker = await startWorker(`(${serveSolver})(self, (${createSolverHost})());`);
    const solver = new Solver(worker);
    await solver.request({module: bytes}, [bytes]);
    return solver;
  }

  constructor(worker) {
    this.worker = worker;
    this.local = worker ? null : createSolverHost();
    this.body = null;
    this.waiting = new Map();
    this.next = 0;
    this.last = Promise.resolve();
    if (!worker) return;
    worker.onmessage = ({data: {id, answer, error}}) => {
      const {resolve, reject} = this.waiting.get(id);
      this.waiting.delete(id);
      if (error) reject(new ClipError(`The solver failed: ${error}.`, kAdvice));
      else resolve(answer);
    };
    worker.onerror = (event) => {
      event.preventDefault();
      for (const {reject} of this.waiting.values()) reject(new ClipError('The solver stopped.', kAdvice));
      this.waiting.clear();
    };
  }

  /** Requests under way. */
  get busy() {
    return this.waiting.size;
  }

  /** Makes `body` (see Body) the solver's. */
  async load(body) {
    if (this.body === body) return;
    this.body = body;
    await this.request(body.request);
  }

  /** Promise of the answer.  Buffers in `transfer` are given away. */
  request(request, transfer = []) {
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, {resolve, reject});
      if (this.worker) this.worker.postMessage({id, request}, transfer);
      else this.last = this.last.then(() => this.#answer(id, request));
    });
  }

  async #answer(id, request) {
    await new Promise((done) => setTimeout(done));  // the page draws in between
    const {resolve, reject} = this.waiting.get(id);
    this.waiting.delete(id);
    try {
      resolve(this.local.handle(request));
    } catch (error) {
      reject(new ClipError(`The solver failed: ${error.message}.`, kAdvice));
    }
  }
}
