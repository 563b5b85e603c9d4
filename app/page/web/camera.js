// A camera that turns around a pivot.  Frame: x right, y down, z forward; u = fx x/z + cx.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const add = (a, b, scale = 1) => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
const normalised = (a) => a.map((value) => value / Math.hypot(...a));

/** v turned around the unit vector `axis` by `angle` radians (Rodrigues). */
function turned(v, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(v.map((value) => c * value), cross(axis, v), s), axis, (1 - c) * dot(axis, v));
}

const kFrustumClamp = 1.3;  // the Jacobian of the projection is taken inside the frustum widened by this factor

/** What drawing needs of a camera: {width, height, fx, fy, cx, cy, R [9] rows, t, centre, bounds, plane}. */
function makeView({width, height, fx, fy, cx, cy}, axes, centre) {
  const extraX = (kFrustumClamp - 1) / 2 * width, extraY = (kFrustumClamp - 1) / 2 * height;
  const t = axes.map((axis) => -dot(axis, centre));
  return {
    width, height, fx, fy, cx, cy, centre, t, R: axes.flat(), plane: [...axes[2], t[2]],
    bounds: [-(cx + extraX) / fx, (width - cx + extraX) / fx, -(cy + extraY) / fy, (height - cy + extraY) / fy],
  };
}

/** Axes (rows of cam_from_world) and centre of a camera as the header has it. */
function poseOf({cam_from_world: m}) {
  const axes = [m.slice(0, 3), m.slice(4, 7), m.slice(8, 11)];
  const t = [m[3], m[7], m[11]];
  return {axes, centre: [0, 1, 2].map((c) => -(axes[0][c] * t[0] + axes[1][c] * t[1] + axes[2][c] * t[2]))};
}

/** View of a camera of the header's form, its picture stretched to width x height. */
export function viewOf(camera, width = camera.width, height = camera.height) {
  const sx = width / camera.width, sy = height / camera.height, {axes, centre} = poseOf(camera);
  return makeView({width, height, fx: camera.fx * sx, fy: camera.fy * sy, cx: camera.cx * sx, cy: camera.cy * sy}, axes,
      centre);
}

/** The camera of the person who looks. */
export class Camera {
  /** Starts as the camera of the clip; `object` is a sphere {centre, radius} around what moves. */
  constructor(clip, up, orbit, object) {
    this.clip = clip;
    this.up = normalised(up);
    this.orbit = orbit;
    this.object = object;
    this.reset();
  }

  /** Back to the camera of the clip. */
  reset() {
    ({axes: this.axes, centre: this.centre} = poseOf(this.clip));
    this.pivot = [...this.orbit.centre];
    this.start = normalised(add(this.centre, this.pivot, -1));
    this.changed = true;
  }

  /** Shows the whole object, seen from the same side. */
  fit() {
    const {width, height, fx, fy} = this.clip, radius = Math.max(this.object.radius, 1e-6) * 1.1;
    const halfAngle = Math.atan(Math.min(width / (2 * fx), height / (2 * fy)));
    const distance = Math.max(radius / Math.sin(halfAngle), 0.3 + radius);
    this.pivot = [...this.object.centre];
    this.centre = add(this.pivot, this.axes[2], -distance);
    this.changed = true;
  }

  /** Turns around the pivot: to the right and upwards (radians). */
  turn(right, upwards) {
    const heightNow = Math.asin(Math.min(1, Math.max(-1, -dot(this.axes[2], this.up)))), limit = 1.5;
    const most = Math.max(limit, Math.abs(heightNow));
    upwards = Math.min(most, Math.max(-most, heightNow + upwards)) - heightNow;
    const rotate = (v) => turned(turned(v, this.axes[0], -upwards), this.up, right);
    this.centre = add(this.pivot, rotate(add(this.centre, this.pivot, -1)));
    const [x, , z] = this.axes.map(rotate), forward = normalised(z);
    const sideways = normalised(add(x, forward, -dot(x, forward)));
    this.axes = [sideways, cross(forward, sideways), forward];
    this.changed = true;
  }

  /** Moves sideways and down by a share of the height of the clip's picture at the distance of the pivot. */
  pan(right, down) {
    const step = this.distance * this.clip.height / this.clip.fy;
    for (const point of ['centre', 'pivot']) {
      this[point] = add(add(this[point], this.axes[0], right * step), this.axes[1], down * step);
    }
    this.changed = true;
  }

  /** Moves towards the pivot; factor < 1 comes closer. */
  zoom(factor) {
    const distance = this.distance, {radius} = this.orbit;
    const least = Math.min(0.02 * radius, distance), most = Math.max(20 * radius, distance);
    const next = Math.min(Math.max(distance * factor, least), most);
    this.centre = add(this.pivot, add(this.centre, this.pivot, -1), next / distance);
    this.changed = true;
  }

  /** From the pivot to the camera (scene units). */
  get distance() {
    return Math.max(Math.hypot(...add(this.centre, this.pivot, -1)), 1e-6);
  }

  /** Angle between the direction of the clip's camera and this one, as seen from the pivot (degrees). */
  get away() {
    const direction = normalised(add(this.centre, this.pivot, -1));
    return Math.acos(Math.min(1, Math.max(-1, dot(direction, this.start)))) * 180 / Math.PI;
  }

  /** Size of the clip's picture within an area, relative to its own size. */
  scaleIn(width, height) {
    return Math.min(width / this.clip.width, height / this.clip.height);
  }

  /** View of a canvas of width x height pixels, in which the clip's picture is contained. */
  view(width, height) {
    const {clip} = this, scale = this.scaleIn(width, height);
    return makeView({
      width, height, fx: clip.fx * scale, fy: clip.fy * scale,
      cx: (clip.cx - clip.width / 2) * scale + width / 2, cy: (clip.cy - clip.height / 2) * scale + height / 2,
    }, this.axes, this.centre);
  }

  /** Takes the pose of a camera of the header's form. */
  take(camera) {
    ({axes: this.axes, centre: this.centre} = poseOf(camera));
    this.changed = true;
  }
}
