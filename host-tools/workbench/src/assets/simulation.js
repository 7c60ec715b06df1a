// A run of a scenario on the simulated rig, into a new recording of the folder.

import { end, get, job } from './api.js';
import { byId, fill, h, quantity, significant } from './dom.js';
import { reload } from './folder.js';
import { changed, state } from './state.js';

let scenarios = [];
/** The run that is simulated: the number of its job. */
let running = null;

/** Reads which scenarios there are; a run that is simulated keeps its form. */
export async function load() {
  scenarios = await get('scenarios');
  if (!running) draw();
}

/** A name that no recording has. */
function freeName() {
  const taken = new Set(state.recordings.map((one) => one.id));
  let number = 1;
  while (taken.has(`run-${number}.mcap`)) number += 1;
  return `run-${number}.mcap`;
}

/** The arguments of `softdock run` that were filled in. */
function wanted(form) {
  const text = (name) => form.get(name).trim() || undefined;
  const number = (name) => (text(name) === undefined ? undefined : Number(text(name)));
  return {
    scenario: form.get('scenario'), output: text('output'), law: text('law'), speed_mm_s: number('speed_mm_s'),
    seed: number('seed'), effect: (text('effect') ?? '').split(/[\s,]+/).filter(Boolean),
  };
}

async function submit(event) {
  event.preventDefault();
  const form = event.target;
  const bar = byId('simulated');
  running = { number: null };
  bar.value = 0;
  show();
  fill('outcome');
  try {
    const found = await job('run', wanted(new FormData(form)), (_, value) => { bar.value = value.share; }, (number) => { running.number = number; });
    fill('outcome', outcome(found));
    await reload();
    form.elements.output.value = freeName();
    changed('selection');
    changed('look');
  } catch (error) {
    fill('outcome', h('p', { class: 'bad', role: 'alert' }, error.message));
  }
  running = null;
  show();
}

function outcome(found) {
  const first = found.impacts[0];
  return [h('p', { class: found.fault ? 'bad' : 'good', id: 'ran' }, `${found.fault ? '✗' : '✓'} ${found.recording}: ${significant(found.simulated_s)} s, mode at the end ${found.final_mode}`,
    found.fault && `, ${found.fault}`),
  first && h('p', { class: 'small' }, `First impact: ${quantity(first.speed_in_mm_s, 'mm/s')} in, ${quantity(first.speed_out_mm_s, 'mm/s')} out, restitution ${significant(first.restitution)}.`),
  found.warnings.map((one) => h('p', { class: 'small muted' }, one))];
}

const field = (label, control) => h('label', {}, h('span', { class: 'small muted' }, label), control);
const entry = (name, placeholder, more = {}) => h('input', { name, placeholder, ...more });
const number = (name, placeholder) => entry(name, placeholder, { type: 'number', step: 'any' });

/** What may be pressed while a run is simulated. */
function show() {
  byId('simulated').hidden = !running;
  byId('end-run').hidden = !running;
  byId('run').disabled = Boolean(running);
}

function draw() {
  byId('simulation').hidden = !scenarios.length;
  const usual = 'as given';
  const form = h('form', { onsubmit: (event) => { submit(event); } },
    h('div', { class: 'fields' },
      field('Scenario', h('select', { name: 'scenario' }, scenarios.map((one) => h('option', {}, one.id)))),
      field('New recording', entry('output', '', { required: true, value: freeName() }))),
    h('div', { class: 'fields' },
      field('Speed, mm/s', number('speed_mm_s', usual)), field('Delay law', entry('law', usual))),
    h('div', { class: 'fields' },
      field('Hidden effects', entry('effect', 'none, or ids')), field('Seed', number('seed', usual))),
    h('div', { class: 'row-line' }, h('button', { id: 'run' }, 'Run'),
      h('progress', { id: 'simulated', max: 1, value: 0, hidden: true, 'aria-label': 'simulating' }),
      h('button', { id: 'end-run', type: 'button', hidden: true, onclick: () => running?.number && end(`jobs/${running.number}`) }, 'Cancel')));
  const open = byId('simulation').querySelector('details')?.open;
  fill('simulation', h('details', { open }, h('summary', {}, h('h2', {}, 'Run a scenario')), form, h('div', { id: 'outcome' })));
}
