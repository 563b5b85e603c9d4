'use strict';
// A study in one file: pairs of clips of which one is chosen, then single clips that are scored.  All answers stay in
// the page until they are saved.
(() => {
  const study = JSON.parse(document.getElementById('study').textContent);
  const $ = (id) => document.getElementById(id);
  const calm = matchMedia('(prefers-reduced-motion: reduce)').matches;

  /** Numbers in [0, 1) that follow from the seeds (mulberry32). */
  function randomOf(...seeds) {
    let state = 0x9e3779b9;
    for (const seed of seeds) state = Math.imul(state ^ (seed >>> 0), 0x85ebca6b) + 0xc2b2ae35 | 0;
    return () => {
      state = state + 0x6d2b79f5 | 0;
      let t = Math.imul(state ^ state >>> 15, state | 1);
      t = t + Math.imul(t ^ t >>> 7, t | 61) ^ t;
      return ((t ^ t >>> 14) >>> 0) / 4294967296;
    };
  }

  function shuffled(list, random) {
    const out = list.slice();
    for (let i = out.length - 1; i > 0; --i) {
      const j = Math.floor(random() * (i + 1));
      [out[i], out[j]] = [out[j], out[i]];
    }
    return out;
  }

  /** What this participant sees: all pairs in random order and sides, then all single clips in random order. */
  function trialsOf(participant) {
    const random = randomOf(study.seed, participant);
    const pairs = shuffled(study.pairs, random).map((pair) => {
      const swapped = random() < 0.5;
      const sides = (first, second) => (swapped ? [second, first] : [first, second]);
      const shown = sides(pair.first, pair.second), methods = sides(...pair.methods);
      return {...pair, kind: pair.check ? 'check' : 'choice', shown, methods};
    });
    const singles = shuffled(study.singles, random).map((single) => ({...single, kind: 'rating', shown: [single.clip]}));
    return pairs.concat(singles);
  }

  const answers = {
    kind: 'study-answers', study: study.id, seed: study.seed, participant: 0, professional: false, started: '',
    finished: '', answers: [],
  };
  let trials = [], at = 0, shownAt = 0, seen = false, playing = false, unsaved = false;

  function element(name, properties = {}, ...children) {
    const node = Object.assign(document.createElement(name), properties);
    node.append(...children);
    return node;
  }

  function show(section) {
    for (const id of ['start', 'trial', 'end']) $(id).hidden = id !== section;
    scrollTo(0, 0);
  }

  const videos = () => [...$('clips').querySelectorAll('video')];

  function setPlaying(wanted) {
    playing = wanted;
    $('play').textContent = playing ? 'Pause' : 'Play';
    for (const video of videos()) {
      if (!playing) video.pause();
      else if (!video.ended) video.play().catch((error) => error.name === 'NotAllowedError' && setPlaying(false));
    }
  }

  /** Clips begin together, and again together when the longest has ended. */
  function restartWhenAllEnded() {
    if (!videos().every((video) => video.ended)) return;
    seen = true;
    if ($('hint').dataset.reason === 'watch') say('', '');
    for (const video of videos()) video.currentTime = 0;
    if (playing) setPlaying(true);
  }

  function say(text, reason) {
    $('hint').textContent = text;
    $('hint').dataset.reason = reason;
  }

  function figure(clip, caption) {
    const video = element('video', {src: study.clips[clip], muted: true, playsInline: true, preload: 'auto'});
    video.setAttribute('aria-label', caption);
    video.addEventListener('ended', restartWhenAllEnded);
    // What cannot be played must not hold anybody up.
    video.addEventListener('error', () => {
      seen = true;
      say('This browser cannot play one of the clips.', 'error');
    });
    return element('figure', {}, element('figcaption', {textContent: caption}), video);
  }

  function fieldset(name, text, options, ends) {
    const choices = element('div', {className: 'choices'});
    for (const {value, label} of options) {
      const input = element('input', {type: 'radio', name, value: String(value), required: true});
      choices.append(element('label', {}, input, label));
    }
    const scale = element('div', {className: 'scale'}, choices);
    if (ends) {
      scale.append(element('p', {className: 'ends'}, element('span', {textContent: ends[0]}),
        element('span', {textContent: ends[1]})));
    }
    return element('fieldset', {}, element('legend', {textContent: text}), scale);
  }

  function showTrial() {
    const trial = trials[at];
    show('trial');
    $('trial-title').textContent = `${trial.shown.length > 1 ? 'Comparison' : 'Clip'} ${at + 1} of ${trials.length}`;
    $('progress').max = trials.length;
    $('progress').value = at;
    const names = trial.shown.length > 1 ? ['A', 'B'] : ['Clip'];
    const figures = trial.shown.map((clip, k) => figure(clip, names[k] === 'Clip' ? 'Clip' : `Clip ${names[k]}`));
    if (trial.reference !== undefined) figures.unshift(figure(trial.reference, 'Reference'));
    $('clips').classList.toggle('with-reference', trial.reference !== undefined);
    $('clips').replaceChildren(...figures);
    const sets = trial.kind === 'rating'
      ? study.ratings.map((r) => fieldset(r.name, r.text, Array.from({length: r.highest - r.lowest + 1},
        (unused, k) => ({value: r.lowest + k, label: String(r.lowest + k)})), [r.lowest_means, r.highest_means]))
      : study.questions.map((q) => fieldset(q.name, q.text, [{value: 0, label: 'A'}, {value: 1, label: 'B'}]));
    $('questions').replaceChildren(...sets);
    say('', '');
    seen = false;
    shownAt = performance.now();
    setPlaying(!calm);
    $('trial-title').focus();
  }

  function finish() {
    answers.finished = new Date().toISOString();
    videos().forEach((video) => video.removeAttribute('src'));
    $('clips').replaceChildren();
    show('end');
    $('end-title').focus();
  }

  $('begin').addEventListener('submit', (event) => {
    event.preventDefault();
    answers.participant = Number($('participant').value);
    answers.professional = $('professional').checked;
    answers.started = new Date().toISOString();
    trials = trialsOf(answers.participant);
    unsaved = true;
    showTrial();
  });

  $('play').addEventListener('click', () => setPlaying(!playing));

  $('answers').addEventListener('submit', (event) => {
    event.preventDefault();
    const trial = trials[at], given = new FormData($('answers'));
    const asked = trial.kind === 'rating' ? study.ratings : study.questions;
    const open = asked.find((question) => given.get(question.name) === null);
    if (open) {
      say('Please answer every question.', 'open');
      $('answers').querySelector(`input[name="${CSS.escape(open.name)}"]`).focus();
      return;
    }
    if (!seen) {
      say('Please watch to the end once.', 'watch');
      if (!playing) setPlaying(true);
      return;
    }
    const seconds = Math.round(performance.now() - shownAt) / 1000;
    for (const question of asked) {
      const value = Number(given.get(question.name));
      if (trial.kind === 'rating') {
        answers.answers.push({kind: 'rating', scene: trial.scene, method: trial.method, rating: question.name, value, seconds});
      } else {
        answers.answers.push({kind: trial.kind, scene: trial.scene, shown: trial.methods, question: question.name,
          chosen: trial.methods[value], seconds});
      }
    }
    ++at;
    at < trials.length ? showTrial() : finish();
  });

  $('save').addEventListener('click', () => {
    const blob = new Blob([JSON.stringify(answers, null, 1)], {type: 'application/json'});
    const link = element('a', {href: URL.createObjectURL(blob), download: `answers_${answers.participant}.json`});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    unsaved = false;
    $('saved').textContent = `Saved as ${link.download}.`;
  });

  addEventListener('beforeunload', (event) => {
    if (unsaved) event.preventDefault();
  });

  $('start-title').textContent = study.title;
  $('introduction').textContent = study.introduction;
  const amounts = [];
  const count = (number, what) => `${number} ${what}${number === 1 ? '' : 's'}`;
  if (study.pairs.length) amounts.push(`${count(study.pairs.length, 'comparison')} of two clips`);
  if (study.singles.length) amounts.push(`${count(study.singles.length, 'clip')} to score`);
  $('amount').textContent = amounts.join(' and ');
  $('participant').value = String(1 + crypto.getRandomValues(new Uint32Array(1))[0] % 999999999);
  // For tests: what a participant would see.
  globalThis.pliantStudy = {trialsOf, answers};
})();
