// Workers made from text, so that the page needs no second file.

const kStartLimit = 3000;  // ms

/** Starts a worker whose script posts a message when it is ready; null when it does not answer or is blocked. */
export function startWorker(source) {
  return new Promise((resolve) => {
    let worker = null;
    const fail = () => {
      worker?.terminate();
      resolve(null);
    };
    try {
      const url = URL.createObjectURL(new Blob([source], {type: 'text/javascript'}));
      worker = new Worker(url);
      const timer = setTimeout(fail, kStartLimit);
      worker.onerror = fail;
      worker.onmessage = () => {
        clearTimeout(timer);
        URL.revokeObjectURL(url);
        resolve(worker);
      };
    } catch {
      fail();
    }
  });
}
