// A hypothesis of the user's own, typed as a formula: it is tried like one of the catalogue.

import { fill, h } from './dom.js';
import { tryEffects } from './diagnosis.js';

const ACTS_ON = ['guide', 'contact', 'wall', 'fx', 'fy', 'fz', 'tx', 'ty', 'tz'];
let trouble = null;

/** `name unit low high`, a line each. */
function parameters(text) {
  const lines = text.split('\n').map((one) => one.trim()).filter(Boolean);
  return Object.fromEntries(lines.map((one) => {
    const [name, unit, low, high, more] = one.split(/\s+/);
    const range = [Number(low), Number(high)];
    if (more !== undefined || high === undefined || range.some(Number.isNaN)) {
      throw new Error(`Parameter "${one}": expected name, unit, smallest and largest value, as in "pitch_m m 0.002 0.02".`);
    }
    return [name, { unit, low: range[0], high: range[1] }];
  }));
}

async function submit(event) {
  event.preventDefault();
  const form = new FormData(event.target);
  try {
    const own = {
      id: form.get('id').trim(), acts_on: form.get('acts_on'),
      formula: form.get('formula').trim(), parameters: parameters(form.get('parameters')),
    };
    trouble.textContent = '';
    await tryEffects(undefined, own);
  } catch (error) {
    trouble.textContent = error.message;
  }
}

const field = (label, control) => h('label', {}, h('span', { class: 'small muted' }, label), control);

export function draw() {
  trouble = h('p', { class: 'bad', role: 'alert' });
  const form = h('form', { onsubmit: (event) => { submit(event); } },
    h('div', { class: 'fields' },
      field('Name', h('input', { name: 'id', required: true, pattern: '[a-z][a-z0-9_]*', placeholder: 'ripple', title: 'lower-case letters, digits and _' })),
      field('Acts on', h('select', { name: 'acts_on' }, ACTS_ON.map((one) => h('option', {}, one))))),
    field('Formula of position, velocity, acceleration, direction, force, time (depth, rate, gap)', h('input', {
      name: 'formula', required: true, placeholder: 'sine_n*sin(2*PI*position/pitch_m) + cosine_n*cos(2*PI*position/pitch_m)',
    })),
    field('Parameters: name, unit, smallest, largest', h('textarea', { name: 'parameters', rows: 3, placeholder: 'sine_n N -20 20\ncosine_n N -20 20\npitch_m m 0.002 0.02' })),
    h('button', {}, 'Try it'), trouble);
  fill('hypothesis', h('details', {}, h('summary', {}, h('h2', {}, 'Own hypothesis')), form));
}
