// Keeps the canvas up to date: drivers of the frame, order by depth, colours, splats.

import {viewOf} from './camera.js';

const kMostPixels = 2.4e6;  // of the canvas
const kFewestPixels = 1e5;  // to which a slow device goes down while the picture changes
const kMostPixelRatio = 2;
const kSlow = 70;           // ms between pictures
const kCalm = 400;          // ms without a change after which the canvas has all its pixels again
const kLongestStep = 0.25;  // s of clip time between two pictures, when a device is slow or a tab was hidden

/**
 * The loop of the page.  Drivers come from `source`, see BakedMotion; one that moves by itself also has `running`,
 * `changed` and `advance(seconds)`.
 */
export class Viewer {
  /** `onFrame` is called after each picture, `onError` once when drawing fails. */
  constructor({canvas, renderer, sorter, camera, player, source, onFrame, onError}) {
    Object.assign(this, {canvas, renderer, sorter, camera, player, source, onFrame, onError});
    this.shown = null;          // frame of the drivers in the renderer
    this.drivers = null;        // these drivers
    this.keepsCentres = false;
    this.centres = null;        // of the object [N, 4], as they were last sorted, where they are kept
    this.onStep = () => {};     // before each step
    this.onMove = () => {};     // with drivers that the renderer was given
    this.centresStale = true;   // the sorter does not have the centres of the object as they are now
    this.orderStale = true;
    this.dirty = true;
    this.ordering = Promise.resolve();
    this.busy = false;          // an order is being made
    this.held = false;          // pictures are made on demand only
    this.stopped = false;
    this.showing = Promise.resolve();
    this.times = {deform: 0, sort: 0, draw: 0};
    this.affordable = this.pixels = kMostPixels;
    this.interval = this.painted = 0;  // ms: mean between pictures, and when the last one was drawn
    this.paced = false;                // it was drawn in the motion that goes on: the time since then tells the pace
    this.resize();
    new ResizeObserver(() => {
      this.resize();
      if (this.started && !this.stopped) this.paint();
    }).observe(canvas);
    canvas.addEventListener('webglcontextlost', () => this.stop());
  }

  /** Another source of drivers, bound by its level (see readLevel). */
  setSource(source, level) {
    this.renderer.setLevel(level);
    this.source = source;
    this.shown = null;
  }

  /** Has the drivers passed on again. */
  touch() {
    this.shown = null;
  }

  /** Adds the background's Gaussians. */
  setBackground(cloud) {
    this.renderer.setBackground(cloud);
    this.sorter.setBlock('background', cloud.positions, cloud.count, this.renderer.firstOfBackground);
    this.orderStale = this.dirty = true;
  }

  /** Shows the first picture, in its right order, and then keeps the canvas up to date. */
  async start() {
    this.move();
    await this.order(false);
    this.started = true;
    this.paint();
    let last = performance.now();
    const tick = (now) => {
      if (this.stopped) return;
      requestAnimationFrame(tick);
      const seconds = Math.min((now - last) / 1000, kLongestStep);
      last = now;
      if (this.held || document.hidden) {
        this.paced = false;
        return;
      }
      this.player.advance(seconds);
      try {
        this.onStep();
        this.source.advance?.(seconds);
        this.pace(now, this.update());
      } catch (error) {
        this.fail(error);
      }
    };
    requestAnimationFrame(tick);
  }

  stop() {
    this.stopped = true;
  }

  fail(error) {
    if (this.stopped) return;
    this.stop();
    this.onError(error);
  }

  /**
   * One step of the loop: moves what has to move, sorts when the sorter is free, draws when something changed.
   * Motion is drawn when it has been sorted; the camera's at once.  True when it drew.
   */
  update() {
    this.move();
    if (this.camera.changed) {
      this.camera.changed = false;
      this.orderStale = this.dirty = true;
    }
    if (!this.busy && (this.centresStale || this.orderStale)) this.order(false).catch((error) => this.fail(error));
    if (!this.dirty) return false;
    this.paint();
    return true;
  }

  /** Gives the canvas fewer pixels when the clip plays slowly, and all of them when nothing changes. */
  pace(now, painted) {
    const playing = this.player.playing || this.source.running;
    if (painted) {
      if (playing && this.paced) this.interval += 0.2 * (Math.min(now - this.painted, 4 * kSlow) - this.interval);
      this.painted = now;
      this.paced = true;
      if (this.interval > kSlow && this.affordable > kFewestPixels) {
        const drawn = Math.min(this.affordable, this.canvas.width * this.canvas.height);
        this.affordable = Math.max(0.6 * drawn, kFewestPixels);
        this.interval = 0;
      }
    }
    if (!playing) this.paced = false;
    const calm = !playing && now - this.painted > kCalm, pixels = calm ? kMostPixels : this.affordable;
    if (pixels === this.pixels) return;
    this.pixels = pixels;
    this.resize();
    this.paint();
  }

  /** Passes the drivers of the frame to the renderer when they changed. */
  move() {
    const frame = this.player.frame;
    if (frame === this.shown && !this.source.changed) return;
    const start = performance.now();
    this.drivers = this.source.frameAt(frame);
    this.renderer.deform(this.drivers);
    this.onMove(this.drivers);
    this.times.deform = performance.now() - start;
    this.shown = frame;
    this.centresStale = true;
  }

  /** Sorts the Gaussians as they are now, after the sort that is under way. */
  order(exact) {
    const run = async () => {
      this.busy = true;
      try {
        if (this.centresStale) {
          this.centresStale = false;
          const centres = await this.renderer.readCentres();
          if (this.keepsCentres) (this.centres ??= new Float32Array(centres.length)).set(centres);
          this.sorter.setBlock('object', centres, this.renderer.objectCount, 0);
        }
        this.orderStale = false;
        this.renderer.setOrder(await this.sorter.sort(this.view().plane, exact));
        this.times.sort = this.sorter.time;
        this.dirty = true;
      } finally {
        this.busy = false;
      }
    };
    return this.ordering = this.ordering.catch(() => {}).then(run);
  }

  view() {
    return this.camera.view(this.canvas.width, this.canvas.height);
  }

  /** The view in CSS pixels of the page. */
  pageView() {
    return this.camera.view(this.canvas.clientWidth, this.canvas.clientHeight);
  }

  paint() {
    const start = performance.now(), view = this.view();
    this.renderer.shade(view.centre);
    this.renderer.draw(view);
    this.times.draw = performance.now() - start;
    this.dirty = false;
    this.onFrame(this.player.frame);
  }

  /** Fits the canvas to its place on the page. */
  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    const ratio = Math.min(devicePixelRatio, kMostPixelRatio, Math.sqrt(this.pixels / Math.max(1, width * height)));
    this.canvas.width = Math.max(1, Math.round(width * ratio));
    this.canvas.height = Math.max(1, Math.round(height * ratio));
    this.dirty = true;
  }

  /** Holds the clip at a frame and draws it, exactly sorted; `camera` has the form of the header's. */
  showFrame(frame, camera = this.camera.clip) {
    const run = async () => {
      this.held = true;
      try {
        await this.#hold(frame, camera);
      } finally {
        this.held = false;
      }
    };
    return this.showing = this.showing.catch(() => {}).then(run);
  }

  async #hold(frame, camera) {
    this.player.jump(frame);
    this.camera.take(camera);
    this.camera.changed = false;
    this.still = camera;
    await this.ordering.catch(() => {});
    this.move();
    this.times.deform = this.#timed(() => this.renderer.deform(this.source.frameAt(frame)));
    await this.order(true);
    this.times.draw = this.#timed(() => this.paint());
  }

  /** Time of work (ms), the graphics processor's included. */
  #timed(work) {
    const start = performance.now();
    work();
    this.renderer.finish();
    return performance.now() - start;
  }

  /** The picture of the camera last given to showFrame, RGBA bytes, top row first. */
  picture(width, height) {
    const view = viewOf(this.still ?? this.camera.clip, width, height);
    this.renderer.shade(view.centre);
    return this.renderer.picture(view);
  }
}
