// What is missing? First whether the recordings can say it, then the search, then its hypotheses. Or: what are all
// parameters of the model as it is?

import { end, job, post } from './api.js';
import { fill, h, percent, quantity, significant, words } from './dom.js';
import { changed, effectsOfModel, selection, state } from './state.js';

/** The answer of the check for what is selected now; none while it is asked. */
let check = null;
/** The search that runs: number, share, what, and the best gain of each hypothesis. */
let running = null;
let failed = null;
let trying = null;

/** Asks whether a diagnosis of what is selected can say anything. */
export async function ask() {
  check = null;
  draw();
  const asked = selection();
  if (!asked.model || !asked.fit.length) return;
  const same = () => JSON.stringify(asked) === JSON.stringify(selection());
  try {
    const answer = await post('check', asked);
    if (same()) check = answer;
  } catch (error) {
    if (same()) check = { ready: false, against: error.message, lacking: [] };
  }
  draw();
}

export async function diagnose() {
  const found = await search('diagnose');
  if (found) state.diagnosis = found;
  draw();
  changed('diagnosis');
}

/** Fits all parameters of the model together and shows what that leaves. */
export async function fitAll() {
  const found = await search('fit');
  if (found) state.trial = { ...found, effects: [], label: 'all parameters fitted anew' };
  draw();
  changed('trial');
}

/** Does a job on what is selected; nothing if it fails, is ended, or another model is looked at by then. */
async function search(kind) {
  if (!check?.ready || running) return null;
  const model = state.model;
  let answer = null;
  Object.assign(state, { diagnosis: null, trial: null });
  running = { number: null, share: 0, what: 'waiting', tried: new Map(), count: 0 };
  failed = null;
  changed('trial');
  draw();
  try {
    const found = await job(kind, selection(), told, (number) => { running.number = number; draw(); });
    if (model === state.model) answer = found;
  } catch (error) {
    failed = error.message;
  }
  running = null;
  return answer;
}

function told(kind, value) {
  if (kind === 'stage') {
    running.share = Math.max(running.share, value.share);
    running.what = value.what;
  } else {
    const name = value.effects.join(' + ');
    const known = running.tried.get(name);
    running.count += 1;
    if (!known || known.gain < value.gain) running.tried.set(name, value);
  }
  running.due ??= requestAnimationFrame(() => {
    if (running) {
      running.due = null;
      draw();
    }
  });
}

export function cancel() {
  if (running?.number) end(`jobs/${running.number}`).catch(() => {});
}

/** Fits effects together and shows what they leave; `hypothesis` is one that no model file has. */
export async function tryEffects(effects, hypothesis) {
  const label = effects?.join(' + ') ?? hypothesis.id;
  const { model } = state;
  trying = label;
  failed = null;
  draw();
  try {
    const found = await job('add', { selection: selection(), effect: effects, hypothesis });
    if (model === state.model) {
      state.trial = { ...found, label };
      changed('trial');
    }
  } catch (error) {
    if (model === state.model) failed = error.message;
  }
  trying = null;
  draw();
}

function checkLines() {
  if (!state.model) return h('p', { class: 'muted' }, 'Choose a model first.');
  if (!state.fit.size) return h('p', { class: 'muted' }, 'Say of at least one recording that a diagnosis may fit on it.');
  if (!check) return h('p', { class: 'muted' }, 'Checking the recordings …');
  const unseen = state.test.size ? [...state.test].join(', ') : 'the end of it';
  return [h('p', { class: check.ready ? '' : 'bad', id: 'check', 'data-ready': String(check.ready) }, check.ready
    ? [h('span', { class: 'good' }, '✓ '), 'Fit for a diagnosis: it fits on ', h('strong', {}, [...state.fit].join(', ')), ' and judges on ', h('strong', {}, unseen), '.']
    : ['✗ Not fit for a diagnosis. ', check.against]),
  check.lacking.length && h('details', { class: 'small', open: !check.ready }, h('summary', {}, `What is lacking (${check.lacking.length})`),
    h('ul', {}, check.lacking.map((one) => h('li', {}, one))))];
}

/** Ids of a hypothesis with those beside which it was tried, but for what the model has. */
function whole(one) {
  const known = new Set(effectsOfModel().map((effect) => effect.id));
  return [...(one.beside ?? []), ...one.effects].filter((id) => !known.has(id));
}

function hypothesisRow(one, largest) {
  const ids = whole(one);
  const name = ids.join(' + ');
  const gain = one.gain ?? one.gain_train + one.gain_test;
  const width = `${Math.max(100 * Math.sqrt(Math.max(gain, 0) / largest), 0.5)}%`;
  return h('li', { class: one.refused ? 'refused' : '', title: one.refused },
    h('div', { class: 'hypothesis' }, h('span', { class: 'name' }, name),
      h('span', { class: 'small muted' }, `Δχ² ${Math.round(gain).toLocaleString('en')}`),
      !one.refused && !running && h('button', {
        'data-try': name, disabled: Boolean(trying), 'aria-pressed': state.trial?.label === name,
        onclick: () => tryEffects(ids), title: `Fit ${ids.length > 1 ? 'them together' : 'it alone'} and show what that leaves`,
      }, trying === name ? 'Trying …' : 'Try')),
    h('div', { class: 'bar thin' }, h('i', { class: `fill ${one.refused ? '' : 'on'}`, style: { width } })),
    one.refused && h('span', { class: 'small muted' }, one.refused));
}

function progress() {
  const best = [...running.tried].filter(([, one]) => one.gain > 0).sort((a, b) => b[1].gain - a[1].gain).slice(0, 6);
  return [h('div', { class: 'row-line' }, h('progress', { max: 1, value: running.share, 'aria-label': running.what }),
    h('button', { id: 'cancel', onclick: cancel, title: 'Escape' }, 'Cancel')),
  h('p', { class: 'small muted' }, `${running.what}${running.count ? ` · ${running.count.toLocaleString('en')} hypotheses tried` : ''}`),
  h('ol', { class: 'hypotheses' }, best.map(([, one]) => hypothesisRow(one, best[0][1].gain)))];
}

/** The unit stands beside the value. */
const nameWithoutUnit = (name) => name.replace(/_(n_s_per_m|n_per_m|rad_s|m_s|n_m|kg|rad|m|s|n|hz)$/, '');

function parameters(found) {
  const rows = Object.entries(found.parameters).flatMap(([effect, all]) => Object.entries(all).map(([name, one]) => h('tr', {},
    h('td', {}, words(nameWithoutUnit(name)), h('div', { class: 'small muted' }, effect)),
    h('td', { class: 'number' }, quantity(one.value, one.unit),
      h('div', { class: 'small muted' }, `${quantity(one.low, one.unit)} to ${quantity(one.high, one.unit)}`)))));
  return rows.length && h('table', { class: 'wide' }, h('thead', {}, h('tr', {}, h('th', {}, 'Parameter'),
    h('th', { class: 'number' }, 'Value, 95 % interval'))), h('tbody', {}, rows));
}

function result(found) {
  const named = found.verdict === 'named' || found.verdict === 'nothing_missing';
  const ranked = found.ranked.slice(0, 10);
  const gain = (one) => one.gain_train + one.gain_test;
  const largest = Math.max(...ranked.map(gain), 1);
  const probable = Object.entries(found.probability).map(([id, p]) => `${id} ${percent(p)}`).join(', ');
  return [h('p', { class: `answer ${named ? 'good' : 'bad'}`, id: 'answer', 'data-verdict': found.verdict }, found.sentence),
    probable && h('p', { class: 'small muted' }, `Probability: ${probable}`),
    parameters(found),
    found.difference && h('button', { class: 'main', id: 'take', onclick: () => {
      state.trial = { ...found, label: found.effects.join(' + ') };
      changed('trial');
    } }, 'Show what it leaves, and add it'),
    ranked.length && h('h3', {}, 'Hypotheses, the likeliest first'),
    ranked.length && h('ol', { class: 'hypotheses' }, ranked.map((one) => hypothesisRow(one, largest))),
    found.experiment && h('p', { class: 'small' }, h('strong', {}, 'To tell it from its rival: '), found.experiment.sentence, '.'),
    found.notes.length && h('details', { class: 'small muted' }, h('summary', {}, 'Notes'), h('ul', {}, found.notes.map((one) => h('li', {}, one)))),
    h('p', { class: 'small muted' }, `Diagnosed in ${significant(found.seconds)} s.`)];
}

export function draw() {
  fill('diagnosis', h('h2', {}, 'What is missing?'), checkLines(),
    running ? progress() : h('div', { class: 'row-line' }, h('button', {
      class: state.diagnosis ? '' : 'main', id: 'diagnose', disabled: !check?.ready || Boolean(trying), onclick: diagnose, title: 'd',
    }, state.diagnosis ? 'Diagnose again' : 'Diagnose'), h('button', {
      class: 'quiet', id: 'fit', disabled: !check?.ready || Boolean(trying), onclick: fitAll, title: 'All parameters of the model together',
    }, 'Fit all parameters')),
    failed && h('p', { class: 'bad', id: 'failed' }, failed),
    !running && state.diagnosis && result(state.diagnosis));
}
