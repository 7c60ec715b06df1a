// How the error fell, step by step: a bar for each step, on data that no fit has seen where there is some.

import { get, id } from './api.js';
import { fill, h, significant } from './dom.js';
import { remove } from './add.js';
import { effectsOfModel, state } from './state.js';

const NAMES = { nominal: 'model as given', edited: 'edited by hand', refit: 'all parameters fitted anew' };
const judged = (step) => step.test_error ?? step.train_error;

/** Steps on the same recordings; only these can be compared. */
function runs(steps) {
  return steps.reduce((all, step) => {
    const last = all.at(-1)?.at(-1);
    if (last && last.train === step.train && last.test === step.test) all.at(-1).push(step);
    else all.push([step]);
    return all;
  }, []);
}

function bar(step, before, largest) {
  const value = judged(step);
  const from = before === undefined ? 0 : Math.min(value, before);
  const change = before === undefined ? value : Math.abs(before - value);
  const kind = before === undefined ? 'on' : value <= before ? 'falls' : 'rises';
  const part = (width, name) => h('i', { class: name, style: { width: `${100 * width / largest}%` } });
  const name = NAMES[step.effect] ?? `+ ${step.effect}`;
  const gone = !NAMES[step.effect] && !effectsOfModel().some((one) => one.id === step.effect);
  return h('li', { class: gone ? 'refused' : '' }, h('span', { class: 'name' }, name, gone && h('span', { class: 'small muted' }, ' (taken out)')),
    h('div', { class: 'bar waterfall' }, before === undefined ? part(value, 'fill on') : [part(from, 'fill on'), part(change, `fill ${kind}`)]),
    h('span', { class: 'number' }, `${significant(value)} σₙ`));
}

function run(steps) {
  const largest = Math.max(...steps.map(judged));
  const where = steps[0].test ? `on ${steps[0].test}, which no fit has seen` : `on ${steps[0].train}`;
  return [h('p', { class: 'small muted' }, `Error ${where}`),
    h('ol', { class: 'waterfalls' }, steps.map((step, k) => bar(step, k ? judged(steps[k - 1]) : undefined, largest)))];
}

/** The effects, each with the way out. */
function effects() {
  return effectsOfModel().length && h('div', { class: 'chips' }, effectsOfModel().map((one) => h('span', { class: 'chip' }, one.id,
    h('button', { class: 'quiet', 'aria-label': `Take ${one.id} out`, title: 'Take it out of the model', onclick: () => remove(one.id) }, '×'))));
}

export async function draw() {
  const model = state.model;
  const steps = model ? (await get(`models/${id(model)}/history`)).steps : [];
  if (model !== state.model) return;
  fill('history', h('h2', {}, 'How the error fell'), effects(), steps.length ? runs(steps).reverse().map(run)
    : h('p', { class: 'muted' }, 'Nothing has been added to this model yet.'));
}
