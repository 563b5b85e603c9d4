// Draws Gaussians with WebGL 2.  The textures of all Gaussians hold the object in their first rows, then the
// background.

import {kWidth} from './cloud.js';
import {ClipError} from './container.js';
import {kDeform, kDriversPerRow} from './deform_shader.js';
import {colourShader, kResolve, kSplatFragment, kSplatsPerInstance, kSplatVertex} from './draw_shaders.js';
import {contextLost, createFramebuffer, kCoverViewport, Program, Texture} from './gl.js';

/** Textures with the rest state of a cloud's colours and the program that evaluates them. */
class CloudColours {
  constructor(gl, cloud, firstRow, moves) {
    this.rows = cloud.rows;
    this.firstRow = firstRow;
    this.seenFrom = null;  // centre of the camera for which the colours hold
    this.ranges = {base: cloud.base, harmonics: cloud.harmonics ?? {low: 0, step: 0}};
    this.program = new Program(gl, kCoverViewport, colourShader(cloud, moves));
    this.base = new Texture(gl, 'rgba16ui', kWidth, cloud.rows).write(cloud.base.packed, cloud.rows);
    if (!cloud.harmonics) return;
    const {packed, layers} = cloud.harmonics;
    this.harmonics = new Texture(gl, 'rgba32ui', kWidth, cloud.rows, layers).write(packed, cloud.rows);
  }
}

/** Vertex array with the indices of the two triangles of each splat of an instance. */
function createQuads(gl) {
  const quads = gl.createVertexArray(), index = new Uint16Array(6 * kSplatsPerInstance);
  const corners = [0, 1, 2, 2, 1, 3];
  for (let k = 0; k < index.length; ++k) index[k] = 4 * Math.floor(k / 6) + corners[k % 6];
  gl.bindVertexArray(quads);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, index, gl.STATIC_DRAW);
  gl.bindVertexArray(null);
  return quads;
}

const kTintShare = 0.85;  // of the colour

/** Splats of a scene in which the object moves. */
export class Renderer {
  /** `object` and `backgroundRows`: the cloud, and room for the background that comes later by `setBackground`. */
  constructor(gl, object, backgroundRows, {antialiased, background}) {
    this.gl = gl;
    this.antialiased = Boolean(antialiased);
    this.background = background;
    this.objectRows = object.rows;
    this.objectCount = object.count;
    const rows = Math.max(1, object.rows + backgroundRows);
    if (rows > gl.getParameter(gl.MAX_TEXTURE_SIZE) || gl.getParameter(gl.MAX_DRAW_BUFFERS) < 4) {
      throw new ClipError('This scene is too large for the graphics hardware.', 'Try another device.');
    }
    this.rest = {};
    this.moved = {};
    for (const [name, data] of Object.entries({
      position: object.positions, covarianceA: object.covarianceA, covarianceB: object.covarianceB, rotation: null,
    })) {
      if (data) this.rest[name] = new Texture(gl, 'rgba32f', kWidth, object.rows).write(data, object.rows);
      this.moved[name] = new Texture(gl, 'rgba32f', kWidth, rows);
    }
    this.colour = new Texture(gl, 'rgba16f', kWidth, rows);
    const outputs = ['position', 'covarianceA', 'covarianceB', 'rotation'];
    this.movedBuffer = createFramebuffer(gl, outputs.map((name) => this.moved[name]));
    this.positionBuffer = createFramebuffer(gl, [this.moved.position]);
    this.colourBuffer = createFramebuffer(gl, [this.colour]);
    if (!this.movedBuffer || !this.positionBuffer || !this.colourBuffer) {
      throw new ClipError('The graphics hardware cannot hold this scene.', 'Try another browser or device.');
    }
    this.deformProgram = new Program(gl, kCoverViewport, kDeform);
    this.splatProgram = new Program(gl, kSplatVertex, kSplatFragment);
    this.resolveProgram = new Program(gl, kCoverViewport, kResolve);
    this.clouds = [new CloudColours(gl, object, 0, true)];
    this.drivers = {};
    this.targets = {};
    this.count = 0;
    this.empty = gl.createVertexArray();
    this.quads = createQuads(gl);
    this.order = new Texture(gl, 'r32ui', kWidth, rows);
    gl.disable(gl.DITHER);
  }

  /** Index of the first Gaussian of the background. */
  get firstOfBackground() {
    return this.objectRows * kWidth;
  }

  /** Adds the Gaussians that never move. */
  setBackground(cloud) {
    if (!cloud.count) return;
    const still = new Float32Array(4 * cloud.rows * kWidth);
    for (let i = 0; i < still.length; i += 4) still[i] = 1;
    this.moved.position.write(cloud.positions, cloud.rows, this.objectRows);
    this.moved.covarianceA.write(cloud.covarianceA, cloud.rows, this.objectRows);
    this.moved.covarianceB.write(cloud.covarianceB, cloud.rows, this.objectRows);
    this.moved.rotation.write(still, cloud.rows, this.objectRows);
    this.clouds.push(new CloudColours(this.gl, cloud, this.objectRows, false));
  }

  /** Binds the object to the drivers of a level (see readLevel). */
  setLevel(level) {
    const gl = this.gl, rows = Math.max(1, Math.ceil(level.count / kDriversPerRow));
    for (const texture of Object.values(this.drivers)) texture.delete();
    const rest = new Float32Array(4 * kDriversPerRow * rows);
    for (let i = 0; i < level.count; ++i) rest.set(level.rest.subarray(3 * i, 3 * i + 3), 4 * i);
    this.drivers = {
      driver: new Texture(gl, 'rgba32ui', kWidth, this.objectRows).write(level.driver, this.objectRows),
      weight: new Texture(gl, 'rg32ui', kWidth, this.objectRows).write(level.weight, this.objectRows),
      driverRest: new Texture(gl, 'rgba32f', kDriversPerRow, rows).write(rest),
      driverNow: new Texture(gl, 'rgba32f', 3 * kDriversPerRow, rows),
      scalar: new Texture(gl, 'r32f', kDriversPerRow, rows),
    };
    this.scalars = new Float32Array(kDriversPerRow * rows);
    this.tint = 0;
    this.packed = new Float32Array(12 * kDriversPerRow * rows);
  }

  /** Moves the object: positions [M, 3] of its drivers and their deformation gradients [M, 9], row-major. */
  deform({positions, gradients}) {
    const gl = this.gl, packed = this.packed;
    for (let m = 0; 3 * m < positions.length; ++m) {
      for (let c = 0; c < 3; ++c) packed[12 * m + c] = positions[3 * m + c];
      for (let c = 0; c < 9; ++c) packed[12 * m + 3 + c] = gradients[9 * m + c];
    }
    this.drivers.driverNow.write(packed);
    this.deformProgram.use({
      ...this.drivers, restPosition: this.rest.position, restCovarianceA: this.rest.covarianceA,
      restCovarianceB: this.rest.covarianceB,
    });
    this.#cover(this.movedBuffer, 0, this.objectRows);
    this.clouds[0].seenFrom = null;
  }

  /** Colours the object by scalars [M] of its drivers, from 0 to 1; by its own colours where they are null. */
  setTint(scalars) {
    this.clouds[0].seenFrom = null;
    this.tint = scalars ? kTintShare : 0;
    if (!scalars) return;
    this.scalars.set(scalars);
    this.drivers.scalar.write(this.scalars);
  }

  /** Promise of the centres of the object's Gaussians as they are now, [objectRows * kWidth, 4]. */
  async readCentres() {
    const gl = this.gl, out = new Float32Array(4 * this.firstOfBackground);
    if (!out.length) return out;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, out.byteLength, gl.STREAM_READ);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.positionBuffer);
    gl.readPixels(0, 0, kWidth, this.objectRows, gl.RGBA, gl.FLOAT, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (!fence) throw contextLost();
    gl.flush();
    while (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise((done) => setTimeout(done, 1));
    gl.deleteSync(fence);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, out);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.deleteBuffer(buffer);
    return out;
  }

  /** Indices of the Gaussians to draw, farthest first. */
  setOrder(order) {
    this.count = order.length;
    this.order.writeFirst(order);
  }

  /** Colours of the Gaussians as seen from the camera's centre (world frame). */
  shade(centre) {
    const gl = this.gl;
    for (const cloud of this.clouds) {
      const {program, base, harmonics, ranges, firstRow, rows, seenFrom} = cloud;
      if (seenFrom && centre.every((value, c) => value === seenFrom[c])) continue;
      cloud.seenFrom = [...centre];
      const textures = {...this.drivers, position: this.moved.position, rotation: this.moved.rotation, base};
      const uniforms = program.use(harmonics ? {...textures, harmonics} : textures);
      gl.uniform1i(uniforms.firstRow, firstRow);
      if ('tint' in uniforms) gl.uniform1f(uniforms.tint, this.tint);
      gl.uniform3fv(uniforms.centre, centre);
      for (const [name, {low, step}] of Object.entries(ranges)) {
        gl.uniform1f(uniforms[`${name}Low`], low);
        gl.uniform1f(uniforms[`${name}Step`], step);
      }
      this.#cover(this.colourBuffer, firstRow, rows);
    }
  }

  /** Draws a view (see Camera.view) onto the canvas, which has the view's size. */
  draw(view) {
    const target = this.#blend(view, 'canvas');
    this.#resolve(target, null, view);
  }

  /** The picture of a view, RGBA bytes, top row first. */
  picture(view) {
    const gl = this.gl, {width, height} = view, bytes = new Uint8Array(4 * width * height);
    const target = this.#blend(view, 'picture');
    this.#resolve(target, target.out.framebuffer, view);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    const flipped = new Uint8Array(bytes.length), stride = 4 * width;
    for (let y = 0; y < height; ++y) {
      flipped.set(bytes.subarray(y * stride, (y + 1) * stride), (height - 1 - y) * stride);
    }
    return flipped;
  }

  /** Waits until all that was asked for has been drawn. */
  finish() {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.positionBuffer);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, new Float32Array(4));
  }

  /** Runs the current program for `rows` rows of a framebuffer. */
  #cover(framebuffer, firstRow, rows) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, firstRow, kWidth, rows);
    gl.disable(gl.BLEND);
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** The target of a use, remade when its size changes: half floats to blend in, and for pictures bytes to read. */
  #target(name, width, height) {
    const gl = this.gl, old = this.targets[name];
    if (old?.texture.width === width && old.texture.height === height) return old;
    for (const {texture, framebuffer} of [old, old?.out].filter(Boolean)) {
      texture.delete();
      gl.deleteFramebuffer(framebuffer);
    }
    const create = (format) => {
      const texture = new Texture(gl, format, width, height);
      return {texture, framebuffer: createFramebuffer(gl, [texture])};
    };
    return this.targets[name] = {...create('rgba16f'), out: name === 'picture' ? create('rgba8') : null};
  }

  #blend(view, name) {
    const gl = this.gl, target = this.#target(name, view.width, view.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    gl.viewport(0, 0, view.width, view.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const uniforms = this.splatProgram.use({...this.moved, colour: this.colour, order: this.order});
    gl.uniformMatrix3fv(uniforms.R, true, view.R);
    gl.uniform3fv(uniforms.t, view.t);
    gl.uniform2f(uniforms.focal, view.fx, view.fy);
    gl.uniform2f(uniforms.principal, view.cx, view.cy);
    gl.uniform2f(uniforms.size, view.width, view.height);
    gl.uniform4fv(uniforms.bounds, view.bounds);
    gl.uniform1i(uniforms.antialiased, this.antialiased ? 1 : 0);
    gl.uniform1i(uniforms.count, this.count);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(this.quads);
    gl.drawElementsInstanced(gl.TRIANGLES, 6 * kSplatsPerInstance, gl.UNSIGNED_SHORT, 0,
        Math.ceil(this.count / kSplatsPerInstance));
    return target;
  }

  #resolve({texture}, framebuffer, {width, height}) {
    const gl = this.gl, uniforms = this.resolveProgram.use({blended: texture});
    gl.uniform3fv(uniforms.background, this.background);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, 0, width, height);
    gl.disable(gl.BLEND);
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
