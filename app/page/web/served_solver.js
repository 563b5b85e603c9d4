// The solver of `pliant view`, which the page reaches by a WebSocket: requests and answers are those of Solver.

import {ClipError} from './container.js';

const kAdvice = 'Reload this page. If it does not load, start pliant view again, and open the address that it prints.';
const kHeader = 32;  // bytes
const kMessage = 60000;  // characters of a message, at most
const kSigned = 32767, kUnsigned = 65535;

/** Address of the server's socket; null on a page that has none. */
export function servedAt() {
  const live = document.querySelector('meta[name="pliant-live"]')?.content;
  return live ? new URL(live, location.href).href.replace(/^http/, 'ws') : null;
}

/** Takes a frame apart, see state_message of app/live/live_messages.h. */
export function readState(buffer) {
  const head = new DataView(buffer), n = head.getUint32(12, true), length = head.getUint32(24, true);
  if (head.getUint32(0, true) !== 0x544e4c50 || head.getUint16(4, true) !== 1) {
    throw new ClipError('The server speaks another version.', kAdvice);
  }
  const meta = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, kHeader, length)));
  const at = kHeader + length, {low, size, speed, gradient} = meta;
  const places = new Uint16Array(buffer, at, 3 * n), rates = new Int16Array(buffer, at + 6 * n, 3 * n);
  const stretches = new Int16Array(buffer, at + 12 * n, 9 * n);
  return {
    ...meta,
    positions: Float32Array.from(places, (q, i) => low[i % 3] + size[i % 3] * q / kUnsigned),
    velocities: Float32Array.from(rates, (q) => speed * q / kSigned),
    gradients: Float32Array.from(stretches, (q, i) => gradient * q / kSigned + (i % 9 % 4 === 0 ? 1 : 0)),
  };
}

/** Stands where Solver does; the bodies are the server's. */
export class ServedSolver {
  /** A connected solver.  Throws where the server does not answer. */
  static connect(address) {
    const solver = new ServedSolver(address);
    return new Promise((resolve, reject) => {
      solver.socket.addEventListener('open', () => resolve(solver));
      solver.socket.addEventListener('close', () => reject(new ClipError('The server does not answer.', kAdvice)));
    });
  }

  constructor(address) {
    this.onsaid = () => {};  // of what the server says by itself
    this.address = address;
    this.body = null;
    this.waiting = new Map();
    this.next = 0;
    this.#open();
  }

  #open() {
    const socket = this.socket = new WebSocket(this.address);
    socket.binaryType = 'arraybuffer';
    socket.onmessage = ({data}) => this.#take(typeof data === 'string' ? JSON.parse(data) : readState(data));
    socket.onclose = () => {
      if (socket === this.socket) this.#giveUp();
    };
  }

  /** What has been asked is not answered any more. */
  #giveUp() {
    for (const {reject} of this.waiting.values()) reject(new ClipError('The server has gone.', kAdvice));
    this.waiting.clear();
  }

  get busy() {
    return this.waiting.size;
  }

  /** Makes `body` (see Body) the one that the next start is of. */
  async load(body) {
    this.body = body;
  }

  /**
   * Promise of the answer to {start: {frame}} or {step: {commands, frames}}.  A start, which needs nothing of the
   * session before, connects again where the connection has ended.
   */
  request({start, step}) {
    if (start) {
      if (this.socket.readyState > WebSocket.OPEN) {
        this.#giveUp();
        this.#open();
      }
      const {count: drivers, clusteredTo: clustered_to} = this.body;
      return this.#send({start: {drivers, clustered_to, frame: start.frame}});
    }
    // Many commands at once go ahead in parts.
    let {commands, frames} = step;
    while (JSON.stringify(commands).length > kMessage) {
      const half = commands.slice(0, commands.length >> 1);
      this.#send({commands: half}).catch(() => {});  // what fails shows in the frame's answer
      commands = commands.slice(half.length);
    }
    return this.#send({commands, frames});
  }

  #send(message) {
    const id = this.next++, {socket} = this, text = JSON.stringify({id, ...message});
    return new Promise((resolve, reject) => {
      if (socket.readyState > WebSocket.OPEN) {
        reject(new ClipError('The server has gone.', kAdvice));
        return;
      }
      this.waiting.set(id, {resolve, reject});
      if (socket.readyState === WebSocket.OPEN) socket.send(text);
      else socket.addEventListener('open', () => socket.send(text));
    });
  }

  #take(message) {
    if (message.said) this.onsaid(message.said);
    const request = this.waiting.get(message.id);
    if (!request) {
      if (message.error) this.onsaid(`pliant view: ${message.error}.`);  // such as a recording that cannot be kept
      return;
    }
    this.waiting.delete(message.id);
    if (message.error) request.reject(new ClipError(`The server refused: ${message.error}.`, kAdvice));
    else request.resolve(message);
  }
}
