// The depth sorter in a worker, or on the main thread where workers are blocked.

import {createDepthSorter, serveDepthSorter} from './depth_sort.js';
import {ClipError} from './container.js';
import {startWorker} from './start_worker.js';

/** Sorts Gaussians by depth, one request at a time. */
export class Sorter {
  static async create() {
    return new Sorter(await startWorker(`(${serveDepthSorter})(self, (${createDepthSorter})());`));
  }

  constructor(worker) {
    this.worker = worker;
    this.local = worker ? null : createDepthSorter();
    this.time = 0;  // ms of the last sort
  }

  /** Centres of a block of Gaussians: positions [count, 4], given away; `first` is the index of the first one. */
  setBlock(name, positions, count, first) {
    const block = {positions, count, first};
    if (this.local) this.local.setBlock(name, block);
    else this.worker.postMessage({name, block}, [positions.buffer]);
  }

  /** Promise of the indices, farthest first; plane [4] gives depths in the camera frame (scene units). */
  async sort(plane, exact = false) {
    if (this.local) {
      const start = performance.now(), order = this.local.sort(plane, exact);
      this.time = performance.now() - start;
      return order;
    }
    const {order, time} = await new Promise((resolve, reject) => {
      this.worker.onmessage = ({data}) => resolve(data);
      this.worker.onerror = (event) => {
        event.preventDefault();
        reject(new ClipError('Sorting the scene by depth failed.', 'Reload the page.'));
      };
      this.worker.postMessage({plane, exact});
    });
    this.time = time;
    return order;
  }
}
