// The page: loads the scene, plays its motion, and lets a person look around.

import {boundingSphere, kWidth, readCloud} from './cloud.js';
import {Camera} from './camera.js';
import {ClipError, Container, readHeader} from './container.js';
import {connectControls, showAbout} from './controls.js';
import {connectGestures} from './gestures.js';
import {contextLost, createContext} from './gl.js';
import {errors, giveUp, report, showStatus} from './messages.js';
import {BakedMotion, emptyLevel, readLevel, Still} from './motion.js';
import {physicsService, solverState} from './physics_service.js';
import {startPhysics} from './physics_start.js';
import {Player} from './player.js';
import {Renderer} from './renderer.js';
import {Sorter} from './sorter.js';
import {Viewer} from './viewer.js';

const kPatience = 800;  // ms that the first picture waits for the background

/** For tests and tools: what went wrong so far, and after `ready` the members that `serve` adds. */
const pliant = window.pliant = {violations: [], errors, solver: {levels: []}};
document.addEventListener('securitypolicyviolation', ({violatedDirective, blockedURI}) => {
  pliant.violations.push({violatedDirective, blockedURI});
});
window.addEventListener('error', ({error}) => error && report(error));
window.addEventListener('unhandledrejection', ({reason}) => report(reason));

let decodeTime = 0;  // ms

function decode(work) {
  const start = performance.now(), result = work();
  decodeTime += performance.now() - start;
  return result;
}

/** Result of `read` from a section that the page can do without: what lacks is reported, and `substitute` returned. */
async function loadOptional(container, name, read, substitute) {
  try {
    if (!await container.load(name)) throw new ClipError(`The ${name} is missing from this file.`);
    return decode(read);
  } catch (error) {
    report(error);
    return substitute;
  } finally {
    container.release(name);
  }
}

async function loadObject(container, header) {
  if (!await container.load('object')) throw new ClipError('The object is missing from this file.');
  return decode(() => readCloud(container, 'object', header.object));
}

/** The drivers of the clip and their motion: {level, source}; without the motion the object is at rest. */
function loadMotion(container, header, {count, rows}) {
  const read = () => {
    const level = readLevel(container, 0, header.levels[0], count, rows);
    return {level, source: new BakedMotion(container, header, level)};
  };
  const level = emptyLevel(rows);
  return loadOptional(container, 'motion', read, {level, source: new Still(level)});
}

function loadBackground(container, header) {
  if (!header.background?.splats) return null;
  return loadOptional(container, 'background', () => readCloud(container, 'background', header.background), null);
}

function serve(viewer, container) {
  Object.assign(pliant, {
    frames: viewer.player.frames,
    /** Promise of frame f drawn, sorted exactly; the camera has the form of the header's. */
    showFrame: (frame, camera) => viewer.showFrame(frame, camera),
    /** Picture of the camera last shown at that size: RGBA bytes, top row first. */
    readPixels: (width, height) => viewer.picture(width, height),
    stats: () => ({
      ms: {inflate: container.inflateTime, decode: decodeTime, ...viewer.times}, bytes: container.bytes,
    }),
  });
}

async function run() {
  const header = readHeader();
  showAbout(header);
  showStatus('Loading…');
  const canvas = document.getElementById('canvas'), gl = createContext(canvas);
  if (!gl) {
    throw new ClipError('This browser or device cannot draw the scene: WebGL 2 with float textures is missing.',
        'Turn on hardware acceleration or try another browser.');
  }
  canvas.addEventListener('webglcontextlost', () => giveUp(contextLost()));

  const sorterStarts = Sorter.create(), container = new Container(header);
  const object = await loadObject(container, header);
  const {level, source} = await loadMotion(container, header, object);
  const backgroundComes = loadBackground(container, header);

  const renderer = new Renderer(gl, object, Math.ceil((header.background?.splats ?? 0) / kWidth), header.render);
  renderer.setLevel(level);
  const sphere = level.count ? boundingSphere(level.rest, level.count, 3)
                             : boundingSphere(object.positions, object.count, 4);
  const camera = new Camera(header.clip.camera, header.up, header.orbit, sphere);
  const player = new Player(source.frames, header.clip.fps);
  if (!matchMedia('(prefers-reduced-motion: reduce)').matches) player.play();
  const controls = connectControls(player, camera);
  let hands = null;  // see startPhysics
  const unseen = document.getElementById('unseen'), seen = (header.orbit.degrees ?? 360) / 2;
  const viewer = new Viewer({
    canvas, renderer, sorter: await sorterStarts, camera, player, source,
    onFrame: () => {
      controls.refresh();
      hands?.marks.refresh();
      hands?.panel.refresh();
      unseen.hidden = camera.away <= seen;
    },
    onError: giveUp,
  });
  connectGestures(canvas, camera, (event, take) => Boolean(hands?.input.claim(event, take)));

  const patience = new Promise((done) => setTimeout(done, kPatience, null));
  const early = await Promise.race([backgroundComes, patience]);
  if (early) viewer.setBackground(early);
  await viewer.start();
  document.getElementById('poster').classList.add('covered');
  const background = await backgroundComes;
  if (background && !early) viewer.setBackground(background);
  serve(viewer, container);
  showStatus('');
  pliant.solver.ready = addPhysics().catch(report);

  async function addPhysics() {
    const started = await startPhysics({container, header, viewer, player, object, recorded: {level, source}});
    if (!started) return;
    hands = started;
    const {physics, input, panel} = hands;
    controls.add({...panel, first: (event) => input.key(event)});
    panel.refresh();
    Object.defineProperties(pliant.solver, Object.getOwnPropertyDescriptors(solverState(physics)));
    Object.assign(pliant, physicsService(hands));
    await physics.measure();
  }
}

pliant.ready = run().catch(async (error) => {
  await giveUp(error);
  throw error;
});
pliant.ready.catch(() => {});
