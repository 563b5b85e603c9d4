// The data of the page: a JSON header, and sections of base64 text that hold the arrays which the header describes.

const kFormat = 'pliant-clip';
const kVersion = 1;
const kTypes = {
  u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, i8: Int8Array, i16: Int16Array, i32: Int32Array,
  f32: Float32Array, f64: Float64Array,
};

/** A failure that a person can understand: what is wrong, and what to do about it. */
export class ClipError extends Error {
  constructor(message, advice = 'Download or copy the file again.') {
    super(message);
    this.name = 'ClipError';
    this.advice = advice;
  }
}

function isNumberList(value, count) {
  return Array.isArray(value) && value.length === count && value.every(Number.isFinite);
}

function isCamera(camera) {
  return camera && ['width', 'height', 'fx', 'fy'].every((key) => camera[key] > 0) &&
      Number.isFinite(camera.cx) && Number.isFinite(camera.cy) && isNumberList(camera.cam_from_world, 12);
}

/** The header of the page, checked: every field that the page needs is there and has the right type. */
export function readHeader() {
  let header;
  try {
    header = JSON.parse(document.getElementById('clip-header').textContent);
  } catch {
    throw new ClipError('The header of this file cannot be read.');
  }
  const again = 'Export it again with Pliant.';
  if (header?.format !== kFormat) throw new ClipError('This file is not a Pliant clip.', again);
  if (header.version > kVersion) {
    throw new ClipError(`This clip has format version ${header.version}; its player reads version ${kVersion}.`, again);
  }
  const valid = {
    version: header.version === kVersion,
    up: isNumberList(header.up, 3) && Math.hypot(...header.up) > 0,
    clip: header.clip?.fps > 0 && Number.isInteger(header.clip.frames) && header.clip.frames > 0 &&
        isCamera(header.clip.camera),
    orbit: isNumberList(header.orbit?.centre, 3) && header.orbit.radius > 0,
    render: isNumberList(header.render?.background, 3),
    object: header.object?.splats >= 0,
    levels: Array.isArray(header.levels) && header.levels.length > 0,
    arrays: Array.isArray(header.arrays),
  };
  const wrong = Object.keys(valid).filter((key) => !valid[key]);
  if (wrong.length) throw new ClipError(`The header of this file is damaged (${wrong.join(', ')}).`);
  return header;
}

/** The element of section `name` when all of its text has been parsed; null when the page has no such section. */
export function section(name) {
  const find = () => {
    const element = document.getElementById(`clip-${name}`);
    if (element?.nextElementSibling) return element;
    return document.readyState === 'loading' ? undefined : element;
  };
  return new Promise((resolve) => {
    const finish = (element) => {
      observer.disconnect();
      document.removeEventListener('readystatechange', look);
      resolve(element);
    };
    const look = () => {
      const element = find();
      if (element !== undefined) finish(element);
    };
    const observer = new MutationObserver(look);
    observer.observe(document.documentElement, {childList: true, subtree: true});
    document.addEventListener('readystatechange', look);
    look();
  });
}

/** The bytes of section `name`; null when there is no such section. */
export async function sectionBytes(name) {
  const element = await section(name);
  if (!element) return null;
  try {
    const text = atob(element.textContent);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < bytes.length; ++i) bytes[i] = text.charCodeAt(i);
    return bytes;
  } catch {
    throw new ClipError(`The ${name} section of this file is cut off or damaged.`);
  }
}

async function inflate(bytes, name) {
  if (typeof DecompressionStream === 'undefined') {
    throw new ClipError('This browser cannot decompress the scene.',
        'Open the file in a current version of Chrome, Edge, Firefox or Safari.');
  }
  try {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
    return await new Response(stream).arrayBuffer();
  } catch {
    throw new ClipError(`The ${name} section of this file is cut off or damaged.`);
  }
}

/** Sections inflated so far, and the arrays within them. */
export class Container {
  constructor(header) {
    this.descriptors = new Map(header.arrays.map((array) => [array.name, array]));
    this.inflated = new Map();
    this.bytes = {};  // of each section, compressed and inflated
    this.inflateTime = 0;  // ms
  }

  /** Waits for a section and inflates it; false when the page does not have it. */
  async load(name) {
    const bytes = await sectionBytes(name);
    if (!bytes) return false;
    const start = performance.now();
    const buffer = await inflate(bytes, name);
    this.inflateTime += performance.now() - start;
    this.bytes[name] = {compressed: bytes.length, inflated: buffer.byteLength};
    this.inflated.set(name, buffer);
    return true;
  }

  /** The bytes of an inflated section, given away. */
  bytesOf(name) {
    const buffer = this.inflated.get(name);
    this.inflated.delete(name);
    return buffer;
  }

  /** Forgets an inflated section. */
  release(name) {
    this.inflated.delete(name);
  }

  has(name) {
    return this.descriptors.has(name);
  }

  /**
   * Array `name` of the given shape, as it is stored: {values, low, span, steps}, where a quantised value stands for
   * low + value / steps * span.
   */
  array(name, shape) {
    const descriptor = this.descriptors.get(name);
    const damaged = (what) => new ClipError(`The data in this file are inconsistent (${name}: ${what}).`);
    if (!descriptor) throw damaged('missing');
    const type = kTypes[descriptor.type];
    if (!type) throw damaged('unknown type');
    if (String(descriptor.shape) !== String(shape)) throw damaged(`shape ${descriptor.shape}, expected ${shape}`);
    const count = shape.reduce((a, b) => a * b, 1), offset = descriptor.offset;
    const buffer = this.inflated.get(descriptor.section);
    if (!buffer) throw damaged(`section ${descriptor.section} is missing`);
    if (!Number.isInteger(offset) || offset < 0 || offset % type.BYTES_PER_ELEMENT ||
        offset + count * type.BYTES_PER_ELEMENT > buffer.byteLength) {
      throw damaged('outside its section');
    }
    const {low = 0, high = 1} = descriptor;
    if (!Number.isFinite(low) || !Number.isFinite(high)) throw damaged('range');
    const values = new type(buffer, offset, count);
    if ((type === Float32Array || type === Float64Array) && !values.every(Number.isFinite)) throw damaged('not finite');
    return {values, low, span: high - low, steps: 2 ** (8 * type.BYTES_PER_ELEMENT) - 1};
  }
}
