// The axis that is looked at: measured over predicted, what is left, a trial, and a second run.

import { columns, get, id } from './api.js';
import { Linked } from './chart.js';
import { byId, fill, h, quantity, trouble, words } from './dom.js';
import { changed, failingWindows, failureOf, state } from './state.js';
import { bestShift, interpolated } from './align.js';

let windows = [];
let picked = null;
/** What was fetched for the axis: columns of the run, of the trial, of the second run, and a recorded column. */
let data = {};
/** The recorded columns of a recording. */
let recorded = { of: null, columns: [] };

export const linked = new Linked({
  windows: () => windows.map((window) => ({ ...window, picked: window === picked })),
  picked: (time) => pick(windows.find((window) => time >= window.from_s && time <= window.to_s) ?? null),
});

const prediction = (recording, job) => columns(`prediction?recording=${id(recording)}&model=${id(state.model)}`
  + `&channel=${state.channel}&axis=${state.axis}${job ? `&job=${job}` : ''}`);

const shown = () => [state.model, state.recording, state.channel, state.axis, state.trial?.job, state.overlay.id, state.column].join();

/** Time and values of the recorded column, if there is one in this recording. */
async function column() {
  const path = `recordings/${id(state.recording)}`;
  if (recorded.of !== state.recording) recorded = { of: state.recording, columns: await get(`${path}/channels`) };
  const known = recorded.columns.some((one) => one.name === state.column);
  return known ? columns(`${path}/series?c=${id(state.column)}`) : null;
}

/** Fetches what the axis needs and draws it. */
export async function load() {
  if (!state.comparison) return fill('plots');
  const asked = shown();
  const { trial, overlay } = state;
  try {
    const fetched = await Promise.all([
      prediction(state.recording),
      trial && prediction(state.recording, trial.job),
      overlay.id && prediction(overlay.id),
      column(),
    ]);
    if (shown() !== asked) return;
    data = { run: fetched[0], trial: fetched[1], second: fetched[2], column: fetched[3] };
    windows = failingWindows(state.channel, state.axis);
    if (!windows.includes(picked)) picked = null;
    draw();
  } catch (error) {
    trouble(error.message);
  }
}

const less = (a, b) => a.map((value, k) => value - b[k]);

/** Says what the error of a window follows, and brings it into view. */
function pick(window) {
  picked = window;
  linked.redraw();
  drawSentence();
}

/** The failing window that many places after the one that was picked. */
export function stepWindow(places) {
  if (!windows.length) return;
  const now = windows.indexOf(picked);
  const next = windows[(Math.max(now, places > 0 ? -1 : 0) + places + windows.length) % windows.length];
  const margin = Math.max(next.to_s - next.from_s, 0.1);
  linked.show(next.from_s - 2 * margin, next.to_s + 2 * margin);
  pick(next);
}

function drawSentence() {
  const failure = failureOf(state.channel, state.axis);
  const what = !failure ? 'Here the model is at the noise: there is nothing to explain.' : failure.sentence;
  const where = picked && h('p', {}, h('i', { class: `dot phase-${picked.phase}` }),
    h('strong', {}, `${words(picked.phase)}, ${picked.from_s.toFixed(3)} s to ${picked.to_s.toFixed(3)} s. `),
    failure?.phases.find((one) => one.phase === picked.phase)
      ? `This phase holds ${Math.round(100 * failure.phases.find((one) => one.phase === picked.phase).share)} % of the error of this axis.` : '');
  fill('window', where || (failure && h('p', { class: 'muted small' }, 'Click on a shaded window to see what its error follows (n: the next one).')),
    picked && h('p', { class: 'follows' }, what));
}

function overlayBar() {
  if (!state.overlay.id) return null;
  const cycle = state.recordings.find((one) => one.id === state.recording)?.cycle_s ?? 0.004;
  const shift = (value) => {
    state.overlay.shift = value;
    draw();
  };
  return h('div', { class: 'overlay' }, h('span', {}, `${state.overlay.id}, shifted by`),
    h('button', { class: 'quiet', onclick: () => shift(state.overlay.shift - cycle), title: 'One cycle earlier ([)' }, '−'),
    h('input', {
      type: 'number', step: cycle, id: 'shift', 'aria-label': 'Shift in seconds', value: state.overlay.shift.toFixed(3),
      onchange: (event) => shift(Number(event.target.value) || 0),
    }), 's',
    h('button', { class: 'quiet', onclick: () => shift(state.overlay.shift + cycle), title: 'One cycle later (])' }, '+'),
    h('button', { onclick: () => shift(bestShift(data.run, data.second) ?? state.overlay.shift), title: 'Where the difference of the two is the least part of what both have' }, 'Align'),
    h('button', { class: 'quiet', onclick: () => { state.overlay.id = null; changed('folder'); changed('overlay'); } }, 'Take away'));
}

/** Moves the second run by so many cycles. */
export function nudge(cycles) {
  if (!state.overlay.id) return;
  state.overlay.shift += cycles * (state.recordings.find((one) => one.id === state.recording)?.cycle_s ?? 0.004);
  draw();
}

/** The choice of a recorded column, as it was measured. */
function columnBar() {
  const choose = (event) => {
    state.column = event.target.value || null;
    load();
  };
  return h('label', { class: 'small muted' }, 'Also as recorded: ', h('select', { id: 'column', onchange: choose }, h('option', { value: '' }, '–'),
    recorded.columns.map((one) => h('option', { value: one.name, selected: one.name === state.column, title: one.about }, one.name))));
}

export function draw() {
  if (!data.run || !state.comparison) return;
  linked.clear();
  const axis = state.comparison.channels.find((one) => one.name === state.channel && one.axis === state.axis);
  if (!axis) return fill('plots');
  const title = `${words(state.channel)} ${state.axis}`;
  fill('plots', h('div', { class: 'title' }, h('h2', {}, title),
    h('span', { class: 'muted small' }, `${quantity(axis.rms, axis.unit)} rms`),
    h('span', { class: 'muted small hint' }, 'drag: zoom · wheel: zoom · double click: all')),
  overlayBar(), h('div', { id: 'upper' }), h('div', { id: 'lower' }), h('div', { id: 'window' }), columnBar(), h('div', { id: 'raw' }));
  const [time, measured, predicted, sigma] = data.run;
  const height = Math.max(180, Math.min(320, window.innerHeight * 0.28));
  const upper = [{ label: 'measured', values: measured, colour: 'blue' },
    { label: 'predicted', values: predicted, colour: 'vermilion', dash: [6, 4] }];
  const two = sigma.map((s) => 2 * s);
  const lower = [{ label: '±2 σ of the noise', values: two, colour: 'band', fill: 'band', width: 0.5 },
    { label: '−2 σ', values: two.map((s) => -s), colour: 'band', width: 0.5, silent: true },
    { label: 'measured − predicted', values: less(measured, predicted), colour: 'bad' }];
  if (data.trial) {
    upper.push({ label: `with ${state.trial.label}`, values: data.trial[2], colour: 'green', dash: [6, 4] });
    lower.push({ label: `with ${state.trial.label}`, values: less(measured, data.trial[2]), colour: 'green' });
  }
  if (data.second) {
    const second = interpolated(data.second[0], data.second[1], time, state.overlay.shift);
    upper.push({ label: 'second run', values: second, colour: 'purple' });
    lower.push({ label: 'run − second run', values: less(measured, second), colour: 'purple' });
  }
  linked.add(byId('upper'), height, { time, series: upper, unit: axis.unit, label: title });
  linked.add(byId('lower'), height * 0.8, { time, series: lower, unit: axis.unit, label: 'difference' });
  if (data.column) {
    const { unit } = recorded.columns.find((one) => one.name === state.column);
    const series = [{ label: state.column, values: data.column[1], colour: 'blue' }];
    linked.add(byId('raw'), height * 0.8, { time: data.column[0], series, unit, label: 'as recorded' });
  }
  drawSentence();
  byId('plots').dataset.drawn = `${state.channel} ${state.axis} ${state.trial?.job ?? ''} ${state.overlay.id ?? ''}`;
}

/** The root mean square of what is left, with the trial if there is one, and without. */
export function left() {
  const rms = (values) => {
    const known = Array.from(values).filter(Number.isFinite);
    return Math.sqrt(known.reduce((sum, v) => sum + v * v, 0) / Math.max(known.length, 1));
  };
  const [, measured, predicted] = data.run;
  return { before: rms(less(measured, predicted)), after: data.trial && rms(less(measured, data.trial[2])) };
}
