// Brings the physics onto the page, where the file and the browser have it.

import {readBodies} from './bodies.js';
import {addDetail} from './controls.js';
import {HandInput} from './hand_input.js';
import {HandMarks} from './hand_marks.js';
import {showStatus} from './messages.js';
import {Overlay} from './overlay.js';
import {Physics} from './physics.js';
import {servedAt, ServedSolver} from './served_solver.js';
import {Solver} from './solver.js';
import {connectPanel} from './tool_panel.js';

const element = (id) => document.getElementById(id);

/** The solver of the page, or of the server that it came from; null where WebAssembly is missing or blocked. */
async function createSolver(container) {
  const address = servedAt();
  if (address) {
    const solver = await ServedSolver.connect(address);
    solver.onsaid = showStatus;
    addDetail('Physics', 'Simulated by pliant view on the computer that this page came from.');
    return solver;
  }
  const bytes = container.bytesOf('solver');
  try {
    return await Solver.create(bytes);
  } catch {
    return null;
  }
}

/**
 * Promise of the physics on the page: {physics, input, marks, panel}; null where the page only plays, which the lines
 * about the clip then say.
 */
export async function startPhysics({container, header, viewer, player, object, recorded}) {
  const playOnly = (why) => {
    addDetail('Physics', `This page only plays the recorded motion${why ? `: ${why}` : ''}.`);
    return null;
  };
  if (!header.solver?.fps || !recorded.level.count) return playOnly(header.plays_only);
  if (!await container.load('levels') || !await container.load('solver')) return playOnly('the solver is missing');
  const bodies = readBodies(container, header, object, recorded);
  const solver = await createSolver(container);
  container.release('levels');
  if (!solver) return playOnly('this browser blocks WebAssembly');
  const legend = element('legend');
  const physics = new Physics({header, viewer, player, solver, bodies, recorded, object, legend});
  const input = new HandInput(physics, element('canvas'));
  const marks = new HandMarks(physics, new Overlay(element('overlay'), element('announcer')));
  return {physics, input, marks, panel: connectPanel(physics, input)};
}
