// What the page says, and the video that stands in where the scene cannot be drawn.

import {ClipError, section, sectionBytes} from './container.js';

const element = (id) => document.getElementById(id);

/** Every problem reported so far, as text. */
export const errors = [];

let gaveUp = false;

/** Says what is under way; nothing when the text is empty. */
export function showStatus(text) {
  element('status').textContent = text;
}

/** Shows the clip's video in place of the scene; false when the page has none. */
async function showVideo() {
  const bytes = await sectionBytes('video').catch(() => null);
  if (!bytes?.length) return false;
  const video = document.createElement('video');
  Object.assign(video, {controls: true, loop: true, muted: true, playsInline: true});
  video.src = URL.createObjectURL(new Blob([bytes], {type: 'video/mp4'}));
  video.setAttribute('aria-label', 'Video of the clip');
  for (const id of ['canvas', 'poster', 'controls', 'show-video']) element(id).hidden = true;
  element('stage').append(video);
  if (!matchMedia('(prefers-reduced-motion: reduce)').matches) video.play().catch(() => {});
  return true;
}

function showAlert(text) {
  errors.push(text);
  element('alert-text').textContent = text;
  element('alert').hidden = false;
  showStatus('');
}

function describe(error) {
  if (error instanceof ClipError) return `${error.message} ${error.advice}`;
  return `Something unexpected went wrong (${error?.message ?? error}). Reload the page.`;
}

/** Reports a problem and offers the video.  The page goes on. */
export async function report(error) {
  if (gaveUp) return;
  showAlert(describe(error));
  if (!await section('video') || gaveUp) return;
  const button = element('show-video');
  button.hidden = false;
  button.onclick = showVideo;
}

/** Gives up drawing the scene: says why, and shows the video or else the poster. */
export async function giveUp(error) {
  if (gaveUp) return;
  gaveUp = true;
  for (const id of ['canvas', 'controls', 'unseen']) element(id).hidden = true;
  element('poster').classList.remove('covered');
  const instead = await showVideo() ? 'The video of the clip is shown instead.' : 'The picture is a frame of the clip.';
  showAlert(`${describe(error)} ${instead}`);
}
