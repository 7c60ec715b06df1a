// The folder: its models, its recordings, and what each recording is for.

import { get, id } from './api.js';
import { fill, h, significant } from './dom.js';
import { changed, state } from './state.js';

/** Reads the folder, and looks at something if nothing is looked at yet. */
export async function reload() {
  [state.models, state.recordings] = await Promise.all([get('models'), get('recordings')]);
  const usable = (list) => list.filter((one) => !one.error).map((one) => one.id);
  const [models, recordings] = [usable(state.models), usable(state.recordings)];
  for (const roles of [state.fit, state.test]) {
    for (const one of roles) if (!recordings.includes(one)) roles.delete(one);
  }
  if (!models.includes(state.model)) {
    const untouched = state.models.find((one) => !one.error && !one.effects.length);
    state.model = untouched?.id ?? models[0] ?? null;
  }
  if (!recordings.includes(state.recording)) chooseRoles(recordings);
  await openModel();
  draw();
}

/** What is called a test is unseen, the rest is fitted on. */
function chooseRoles(recordings) {
  const folder = (one) => one.slice(0, one.lastIndexOf('/') + 1);
  const near = recordings.filter((one) => folder(one) === folder(state.model ?? ''));
  const mine = near.length ? near : recordings;
  const isTest = (one) => /test|unseen|valid/i.test(one.slice(folder(one).length));
  state.test = new Set(mine.filter(isTest).slice(0, 1));
  state.fit = new Set(mine.filter((one) => !isTest(one)).slice(0, 1));
  if (!state.fit.size) [state.fit, state.test] = [state.test, state.fit];
  state.recording = [...state.test, ...state.fit][0] ?? null;
}

/** Reads the text of the model that is looked at. */
export async function openModel() {
  state.file = state.model ? await get(`models/${id(state.model)}`) : null;
}

async function look(model, recording) {
  if (model !== state.model) Object.assign(state, { diagnosis: null, trial: null });
  Object.assign(state, { model, recording });
  await openModel();
  draw();
  changed('selection');
  changed('look');
}

function setRole(recording, role) {
  const had = state[role].has(recording);
  state.fit.delete(recording);
  state.test.delete(recording);
  if (!had) state[role].add(recording);
  state.diagnosis = null;
  draw();
  changed('selection');
}

function setOverlay(recording) {
  state.overlay = { id: state.overlay.id === recording ? null : recording, shift: 0 };
  draw();
  changed('overlay');
}

function modelRow(one) {
  const effects = one.effects.length ? one.effects.map((effect) => `+ ${effect}`).join('  ') : 'as given';
  return h('button', {
    class: 'row', 'aria-pressed': one.id === state.model, disabled: Boolean(one.error), title: one.error ?? one.id,
    'data-model': one.id, onclick: () => look(one.id, state.recording),
  }, h('span', { class: 'name' }, one.id), h('span', { class: 'muted small' }, one.error ?? effects));
}

function recordingRow(one) {
  const role = (name, label, title) => h('button', {
    class: 'role', 'aria-pressed': state[name].has(one.id), title, 'data-role': name, onclick: () => setRole(one.id, name),
  }, label);
  const about = one.error ?? `${significant(one.duration_s)} s · ${one.cycles.toLocaleString('en')} cycles`;
  const other = state.recordings.find((own) => own.id === state.recording);
  const settings = other && !one.error && other.settings_hash !== one.settings_hash;
  return h('div', { class: 'recording', 'data-recording': one.id },
    h('button', {
      class: 'row', 'aria-pressed': one.id === state.recording, disabled: Boolean(one.error), title: one.error ?? one.firmware,
      onclick: () => look(state.model, one.id),
    }, h('span', { class: 'name' }, one.id), h('span', { class: 'muted small' }, about,
      one.truncated && h('span', { class: 'bad', title: one.truncated }, ' · cut off'),
      settings && h('span', { title: 'Its board had other settings than that of the run that is shown' }, ' · other settings'))),
    !one.error && h('div', { class: 'roles' },
      role('fit', 'fit', 'A diagnosis fits on it'), role('test', 'unseen', 'A diagnosis judges on it'),
      one.id !== state.recording && h('button', {
        class: 'role', 'aria-pressed': one.id === state.overlay.id, title: 'Lay it over the run that is shown',
        'data-role': 'overlay', onclick: () => setOverlay(one.id),
      }, 'overlay')));
}

function empty(what, command) {
  return h('p', { class: 'muted small' }, `No ${what} here. `, h('code', {}, command), ' makes one.');
}

/** On a narrow screen the folder is a line that opens. */
const wide = matchMedia('(min-width: 760px)');
let open = false;

wide.addEventListener('change', () => draw());

export function draw() {
  const short = [state.model ?? 'no model', state.recording ?? 'no recording'].join(' · ');
  const toggled = (event) => { if (!wide.matches) open = event.target.open; };
  fill('folder', h('details', { open: wide.matches || open, ontoggle: toggled },
    h('summary', {}, short),
    h('h2', {}, 'Models'),
    state.models.length ? state.models.map(modelRow) : empty('models', 'softdock import LOG -o DIR'),
    h('h2', {}, 'Recordings'),
    state.recordings.length ? state.recordings.map(recordingRow) : empty('recordings', 'softdock record'),
    h('button', { class: 'quiet', onclick: () => reload().then(() => { changed('look'); changed('read'); }) }, 'Read the folder again')));
}
