// Thin helpers over WebGL 2.

import {ClipError} from './container.js';

/** Draws a triangle that covers the viewport, without attributes. */
export const kCoverViewport = `#version 300 es
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3. : -1., gl_VertexID == 2 ? 3. : -1., 0., 1.);
}`;

/** The context of a canvas; null when the device lacks WebGL 2 or drawing into float textures. */
export function createContext(canvas) {
  const gl = canvas.getContext('webgl2', {
    alpha: false, antialias: false, depth: false, stencil: false, powerPreference: 'high-performance',
  });
  return gl?.getExtension('EXT_color_buffer_float') ? gl : null;
}

/** The failure of a device that has dropped the context. */
export function contextLost() {
  return new ClipError('The graphics driver stopped drawing this page.', 'Reload the page.');
}

function compile(gl, type, source) {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
}

/** A program and its uniform locations by name. */
export class Program {
  constructor(gl, vertex, fragment) {
    const program = gl.createProgram();
    const shaders = [compile(gl, gl.VERTEX_SHADER, vertex), compile(gl, gl.FRAGMENT_SHADER, fragment)];
    for (const shader of shaders) gl.attachShader(program, shader);
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const log = shaders.map((shader) => gl.getShaderInfoLog(shader)).join('') || gl.getProgramInfoLog(program);
      throw new ClipError(`The graphics driver refused a shader: ${log.trim().split('\n')[0]}`,
          'Update the graphics driver or try another browser.');
    }
    for (const shader of shaders) gl.deleteShader(shader);
    this.gl = gl;
    this.program = program;
    this.uniforms = {};
    this.units = {};
    let unit = 0;
    gl.useProgram(program);
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
      const {name, type} = gl.getActiveUniform(program, i);
      this.uniforms[name] = gl.getUniformLocation(program, name);
      if (![gl.SAMPLER_2D, gl.UNSIGNED_INT_SAMPLER_2D, gl.UNSIGNED_INT_SAMPLER_2D_ARRAY].includes(type)) continue;
      gl.uniform1i(this.uniforms[name], unit);
      this.units[name] = unit++;
    }
  }

  /** Makes the program current with the textures {sampler name: texture}. */
  use(textures = {}) {
    const gl = this.gl;
    gl.useProgram(this.program);
    for (const [name, {target, texture}] of Object.entries(textures)) {
      if (!(name in this.units)) continue;
      gl.activeTexture(gl.TEXTURE0 + this.units[name]);
      gl.bindTexture(target, texture);
    }
    return this.uniforms;
  }
}

function texelLayout(gl, format) {
  return {
    r32f: [gl.R32F, gl.RED, gl.FLOAT],
    rgba32f: [gl.RGBA32F, gl.RGBA, gl.FLOAT],
    rgba16f: [gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT],
    rgba8: [gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE],
    rgba16ui: [gl.RGBA16UI, gl.RGBA_INTEGER, gl.UNSIGNED_SHORT],
    rgba32ui: [gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT],
    rg32ui: [gl.RG32UI, gl.RG_INTEGER, gl.UNSIGNED_INT],
    r32ui: [gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT],
  }[format];
}

/** A texture that is read texel by texel: 2D, or an array when layers > 0. */
export class Texture {
  constructor(gl, format, width, height, layers = 0) {
    this.gl = gl;
    this.layout = texelLayout(gl, format);
    this.width = width;
    this.height = Math.max(1, height);
    this.layers = layers;
    this.target = layers ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
    this.texture = gl.createTexture();
    gl.bindTexture(this.target, this.texture);
    if (layers) gl.texStorage3D(this.target, 1, this.layout[0], width, this.height, layers);
    else gl.texStorage2D(this.target, 1, this.layout[0], width, this.height);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
      gl.texParameteri(this.target, filter, gl.NEAREST);
    }
  }

  /** Writes whole rows, from `firstRow` on, in all layers. */
  write(data, rows = this.height, firstRow = 0) {
    if (!rows) return this;
    const gl = this.gl, [, format, type] = this.layout;
    gl.bindTexture(this.target, this.texture);
    if (this.layers) {
      gl.texSubImage3D(this.target, 0, 0, firstRow, 0, this.width, rows, this.layers, format, type, data);
    } else {
      gl.texSubImage2D(this.target, 0, 0, firstRow, this.width, rows, format, type, data);
    }
    return this;
  }

  /** Writes the first texels of a 2D texture with one component, not only in whole rows. */
  writeFirst(data) {
    const gl = this.gl, [, format, type] = this.layout;
    const rows = Math.floor(data.length / this.width), whole = rows * this.width, rest = data.length - whole;
    this.write(data.subarray(0, whole), rows);
    if (!rest) return;
    gl.bindTexture(this.target, this.texture);
    gl.texSubImage2D(this.target, 0, 0, rows, rest, 1, format, type, data.subarray(whole));
  }

  delete() {
    this.gl.deleteTexture(this.texture);
  }
}

/** A framebuffer that draws into the given textures; null when the device does not support it. */
export function createFramebuffer(gl, textures) {
  const framebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  textures.forEach(({texture}, i) => {
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
  });
  gl.drawBuffers(textures.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
  const complete = gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE || gl.isContextLost();
  return complete ? framebuffer : null;
}
