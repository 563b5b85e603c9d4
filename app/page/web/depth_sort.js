// Back-to-front order of the Gaussians.  The functions here also run in a worker, which is made from their text, so
// they refer to nothing outside themselves.

/**
 * A sorter by depth along the camera's forward axis.  Centres come in blocks: {positions [count, 4], count, first},
 * where `first` is the index of the block's first Gaussian.
 */
export function createDepthSorter() {
  const kNear = 0.2, kBuckets = 65536;
  const blocks = new Map(), histogram = new Uint32Array(kBuckets);
  let depth = new Float32Array(0), index = new Uint32Array(0), spare = new Uint32Array(0);
  let key = new Uint16Array(0), bits = new Uint32Array(0);

  function reserve(count) {
    if (depth.length >= count) return;
    depth = new Float32Array(count);
    bits = new Uint32Array(depth.buffer);  // of positive numbers, they grow with the number, nearly as its logarithm
    index = new Uint32Array(count);
    spare = new Uint32Array(count);
    key = new Uint16Array(count);
  }

  /** One stable counting sort of the keys, largest first: positions[from] -> to. */
  function countingSort(from, to, count) {
    histogram.fill(0);
    for (let i = 0; i < count; ++i) ++histogram[key[from ? from[i] : i]];
    let next = 0;
    for (let k = kBuckets - 1; k >= 0; --k) {
      const size = histogram[k];
      histogram[k] = next;
      next += size;
    }
    for (let i = 0; i < count; ++i) {
      const at = from ? from[i] : i;
      to[histogram[key[at]]++] = at;
    }
  }

  return {
    setBlock(name, block) {
      blocks.set(name, block);
    },

    /**
     * Indices of the Gaussians in front of the camera, farthest first.  The plane gives the depth of (x, y, z) as
     * plane . (x, y, z, 1).  Depths are told apart to about one part in 10^4, or exactly on demand.
     */
    sort(plane, exact) {
      let total = 0, count = 0, low = Infinity, high = 0;
      for (const block of blocks.values()) total += block.count;
      reserve(total);
      for (const {positions, count: size, first} of blocks.values()) {
        for (let i = 0; i < size; ++i) {
          const z = plane[0] * positions[4 * i] + plane[1] * positions[4 * i + 1] + plane[2] * positions[4 * i + 2] +
              plane[3];
          if (!(z > kNear && z < Infinity)) continue;
          depth[count] = z;
          low = Math.min(low, z);
          high = Math.max(high, z);
          index[count++] = first + i;
        }
      }
      const order = new Uint32Array(count);
      if (count === 0) return order;
      if (exact) {
        for (let i = 0; i < count; ++i) key[i] = bits[i] & 65535;
        countingSort(null, spare, count);
        for (let i = 0; i < count; ++i) key[i] = bits[i] >>> 16;
        countingSort(spare, order, count);
      } else {
        const ends = new Uint32Array(new Float32Array([low, high]).buffer);
        const scale = ends[1] > ends[0] ? (kBuckets - 1) / (ends[1] - ends[0]) : 0;
        for (let i = 0; i < count; ++i) key[i] = (bits[i] - ends[0]) * scale;
        countingSort(null, order, count);
      }
      for (let i = 0; i < count; ++i) order[i] = index[order[i]];
      return order;
    },
  };
}

/** Serves requests {name, block} and {plane, exact} that come to the scope of a worker; answers {order, time}. */
export function serveDepthSorter(scope, sorter) {
  scope.onmessage = ({data: {name, block, plane, exact}}) => {
    if (block) {
      sorter.setBlock(name, block);
      return;
    }
    const start = performance.now(), order = sorter.sort(plane, exact);
    scope.postMessage({order, time: performance.now() - start}, [order.buffer]);
  };
  scope.postMessage({ready: true});
}
