/** The clock of the clip.  Frame f is shown from time f / fps on; the last one as long as the others. */
export class Player {
  constructor(frames, fps) {
    this.frames = frames;
    this.fps = fps;
    this.position = 0;  // frames, not whole in slow motion
    this.speed = 1;
    this.loop = true;
    this.playing = false;
    this.onUse = () => {};  // before someone plays or goes to a frame
  }

  /** Frame to show now; between two frames only in slow motion. */
  get frame() {
    const last = this.frames - 1;
    return Math.min(this.speed < 1 ? this.position : Math.floor(this.position), last);
  }

  /** Plays, from the start again when the end has been reached. */
  play() {
    this.onUse();
    if (this.position >= this.frames - 1) this.position = 0;
    this.playing = this.frames > 1;
  }

  pause() {
    this.playing = false;
  }

  seek(frame) {
    this.position = Math.min(Math.max(frame, 0), this.frames - 1);
  }

  /** Pauses at a frame. */
  jump(frame) {
    this.onUse();
    this.pause();
    this.seek(frame);
  }

  /** Pauses and goes some frames forwards or back, around the ends in a loop. */
  step(frames) {
    this.onUse();
    const next = Math.floor(this.position) + frames;
    this.jump(this.loop ? (next % this.frames + this.frames) % this.frames : next);
  }

  /** Lets time pass. */
  advance(seconds) {
    if (!this.playing) return;
    this.position += seconds * this.fps * this.speed;
    if (this.position < this.frames) return;
    if (this.loop) {
      this.position %= this.frames;
    } else {
      this.position = this.frames - 1;
      this.pause();
    }
  }
}
