// Into the model file: first the difference, then the change, and the way back.

import { id, post } from './api.js';
import { byId, fill, h, quantity, significant, trouble } from './dom.js';
import { openModel, reload } from './folder.js';
import { changed, state } from './state.js';
import { left } from './plots.js';

/** What was written last: the effects that can be taken out again. */
let written = null;

function line(text) {
  const kind = /^(\+\+\+|---|@@)/.test(text) ? 'muted' : { '+': 'added', '-': 'removed' }[text[0]];
  return h('span', { class: kind }, `${text}\n`);
}

const difference = (text) => h('pre', { class: 'difference' }, text.trimEnd().split('\n').map(line));

/** The error before and after, on unseen data where there is some. */
function fall(trial) {
  const [first, last] = [trial.steps[0], trial.steps.at(-1)];
  const [before, after] = [first.test_error ?? first.train_error, last.test_error ?? last.train_error];
  const where = first.test_error === null ? 'the data of the fit' : 'unseen data';
  return h('p', { class: 'fall' }, 'Error on ', where, ': ', h('strong', {}, significant(before)), ' → ',
    h('strong', { class: after < before ? 'good' : 'bad' }, significant(after)), ' σ');
}

async function write(trial, force) {
  try {
    await post(`models/${id(state.model)}/effects`, { job: trial.job, if_match: trial.if_match, force });
    written = { model: state.model, effects: trial.effects };
    await afterChange();
  } catch (error) {
    refused(error);
  }
}

/** Takes effects out of the model file. */
export async function remove(effects) {
  try {
    for (const effect of effects) {
      await openModel();
      await post(`models/${id(state.model)}/effects/${id(effect)}/remove`, { if_match: state.file.if_match, write: true });
    }
    written = null;
    await afterChange();
  } catch (error) {
    refused(error);
  }
}

function refused(error) {
  trouble(error.message);
  if (error.status === 409) reload().then(() => changed('look'));
}

async function afterChange() {
  Object.assign(state, { trial: null, diagnosis: null });
  await reload();
  trouble(null);
  changed('selection');
  changed('look');
}

function here() {
  const { before, after } = left();
  const unit = state.comparison.channels.find((one) => one.name === state.channel && one.axis === state.axis).unit;
  return after !== undefined && h('p', { class: 'small muted' },
    `In the plot: ${quantity(before, unit)} rms → ${quantity(after, unit)} rms.`);
}

export function draw() {
  const { trial } = state;
  byId('addition').hidden = !trial && written?.model !== state.model;
  if (!trial) {
    return fill('addition', written && [h('h2', {}, 'Added'), h('p', { class: 'good', id: 'added' }, `✓ ${written.effects.join(', ')} now stands in ${written.model}.`),
      h('button', { id: 'undo', onclick: () => remove(written.effects) }, 'Undo')]);
  }
  fill('addition', h('h2', {}, `With ${trial.label}`), fall(trial), here(),
    trial.doubt && h('p', { class: 'bad', id: 'doubt' }, trial.doubt),
    trial.difference
      ? [h('p', { class: 'small muted' }, `What changes in ${state.model}:`), difference(trial.difference),
        h('div', { class: 'row-line' }, h('button', {
          class: trial.doubt ? '' : 'main', id: 'write', onclick: () => write(trial, Boolean(trial.doubt)),
        }, trial.doubt ? 'Add it all the same' : 'Add to the model'),
        h('button', { class: 'quiet', id: 'drop', onclick: () => { state.trial = null; changed('trial'); } }, 'Leave it'))]
      : h('p', {}, 'There is nothing to add.'));
}
