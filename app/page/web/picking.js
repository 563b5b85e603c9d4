// Between the picture and the scene.  Views are those of Camera.view; pixels count from the view's top left corner.

const kSpread = 0.5;       // of the reach: standard deviation of the weight of what lies beside the pointer
const kFront = 0.25;       // share of the weight that lies in front of the surface
const kLeastWeight = 0.3;  // of all that lies near the pointer
const kThickness = 0.02;   // of the depth: what counts as lying on the surface

/** Where a point of the scene is in a view: {x, y (px), depth (scene units)}. */
export function project({R, t, fx, fy, cx, cy}, [x, y, z]) {
  const row = (k) => R[3 * k] * x + R[3 * k + 1] * y + R[3 * k + 2] * z + t[k], depth = row(2);
  return {x: fx * row(0) / depth + cx, y: fy * row(1) / depth + cy, depth};
}

/** The point of the scene that a view shows at a pixel, at a depth. */
export function unproject({R, centre, fx, fy, cx, cy}, x, y, depth) {
  const ray = [(x - cx) / fx * depth, (y - cy) / fy * depth, depth];
  return centre.map((value, c) => value + R[c] * ray[0] + R[3 + c] * ray[1] + R[6 + c] * ray[2]);
}

/** Axes of a view in the scene: {right, down, forward}. */
export function axesOf({R}) {
  return {right: R.slice(0, 3), down: R.slice(3, 6), forward: R.slice(6, 9)};
}

/**
 * The Gaussian of the object's visible surface nearest to a pixel: {index, place, depth}, null where there is none.
 * `centres` [N, 4] are places now and opacities, `movable` [N] says which ones follow drivers, `reach` is in pixels.
 * Few faint Gaussians in front of the surface do not count, and nothing but the object does.
 */
export function pick(view, centres, movable, x, y, reach) {
  const {R, t, fx, fy, cx, cy} = view, near = [];
  let total = 0;
  for (let i = 0; i < movable.length; ++i) {
    if (!movable[i]) continue;
    const px = centres[4 * i], py = centres[4 * i + 1], pz = centres[4 * i + 2];
    const depth = R[6] * px + R[7] * py + R[8] * pz + t[2];
    if (!(depth > 0)) continue;
    const dx = fx * (R[0] * px + R[1] * py + R[2] * pz + t[0]) / depth + cx - x;
    const dy = fy * (R[3] * px + R[4] * py + R[5] * pz + t[1]) / depth + cy - y;
    const squared = (dx * dx + dy * dy) / (reach * reach);
    if (!(squared < 1)) continue;
    const weight = centres[4 * i + 3] * Math.exp(-squared / (2 * kSpread * kSpread));
    total += weight;
    near.push({index: i, depth, weight, squared});
  }
  if (total < kLeastWeight) return null;
  near.sort((a, b) => a.depth - b.depth);
  const most = kFront * Math.min(total, 4);
  let sum = 0, surface = near[0].depth;
  for (const {depth, weight} of near) {
    surface = depth;
    if ((sum += weight) >= most) break;
  }
  const seen = near.filter(({depth}) => Math.abs(depth - surface) <= kThickness * surface);
  const {index, depth} = seen.reduce((a, b) => b.weight > a.weight ? b : a);
  return {index, depth, place: [...centres.subarray(4 * index, 4 * index + 3)]};
}
