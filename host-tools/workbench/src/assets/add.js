// Into the model file: first the difference, then the change, and the way back.

import { id, post } from './api.js';
import { byId, fill, h, quantity, significant, trouble } from './dom.js';
import { openModel, reload } from './folder.js';
import { changed, state } from './state.js';
import { left } from './plots.js';

/** What was written last, and can be taken back. */
let written = null;
/** The effect that is to be taken out, with the difference that this makes. */
let removal = null;
/** What of it is drawn: a button that is drawn anew between press and release is not clicked. */
let shown;

function line(text) {
  const kind = /^(\+\+\+|---|@@)/.test(text) ? 'muted' : { '+': 'added', '-': 'removed' }[text[0]];
  return h('span', { class: kind }, `${text}\n`);
}

const difference = (text) => h('pre', { class: 'difference' }, text.trimEnd().split('\n').map(line));

/** The error before and after, on unseen data where there is some. */
function fall(trial) {
  const [first, last] = [trial.steps[0], trial.steps.at(-1)];
  const [before, after] = [first.test_error ?? first.train_error, last.test_error ?? last.train_error];
  // Each channel that has an error at all has one of 1 when only noise is left.
  const noisy = Object.values(trial.residual_rms_sigma?.before ?? {}).filter((one) => one > 1e-6).length;
  const where = first.test_error === null ? 'the data of the fit' : 'unseen data';
  return h('p', { class: 'fall' }, 'Error on ', where, ': ', h('strong', {}, significant(before)), ' → ',
    h('strong', { class: after < before ? 'good' : 'bad' }, significant(after)), ' σₙ',
    noisy > 0 && h('span', { class: 'small muted' }, ` (all channels together; ${significant(Math.sqrt(noisy))} is noise)`));
}

async function write(trial, force) {
  try {
    await post(`models/${id(state.model)}/effects`, { job: trial.job, if_match: trial.if_match, force });
    const what = trial.effects.length ? `${trial.effects.join(', ')} now stands` : 'The fitted values now stand';
    written = { model: state.model, what };
    await afterChange();
  } catch (error) {
    refused(error);
  }
}

const takeOut = (effect, wish) => post(`models/${id(state.model)}/effects/${id(effect)}/remove`, wish);

/** Shows what the model file is without an effect. */
export async function remove(effect) {
  try {
    await openModel();
    const { model } = state;
    const { difference, if_match } = await takeOut(effect, { if_match: state.file.if_match, write: false });
    if (model !== state.model) return;
    state.trial = null;
    removal = { model, effect, difference, if_match };
    changed('trial');
    byId('addition').scrollIntoView({ block: 'nearest', behavior: 'smooth' });
  } catch (error) {
    refused(error);
  }
}

/** Takes it out of the file, as it was shown. */
async function writeRemoval({ effect, if_match }) {
  try {
    await takeOut(effect, { if_match, write: true });
    written = { model: state.model, what: `${effect} no longer stands` };
    await afterChange();
  } catch (error) {
    refused(error);
  }
}

/** Gives the model file the text that it had before it was written last, with all that a fit had moved. */
async function undo() {
  try {
    await openModel();
    await post(`models/${id(state.model)}/undo`, { if_match: state.file.if_match });
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
  removal = null;
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

/** What a fit of all parameters says of each; those of a diagnosis stand with it. */
function fitted(trial) {
  const row = (one) => h('tr', { class: one.kept ? 'muted' : '' }, h('td', {}, one.name, one.note && h('div', { class: 'small muted' }, one.note)),
    h('td', { class: 'number' }, quantity(one.before, one.unit)),
    h('td', { class: 'number' }, quantity(one.value, one.unit),
      h('div', { class: 'small muted' }, `${quantity(one.low, one.unit)} to ${quantity(one.high, one.unit)}`)));
  const news = trial.parameters.filter((one) => !one.kept);
  const rest = trial.parameters.filter((one) => one.kept);
  const table = (rows) => h('table', { class: 'wide', id: 'fitted' }, h('thead', {}, h('tr', {}, h('th', {}, 'Parameter'),
    h('th', { class: 'number' }, 'Before'), h('th', { class: 'number' }, 'Value, 95 % interval'))), h('tbody', {}, rows.map(row)));
  const unsaid = trial.undetermined.map((one) => h('li', {}, `${one.name}: ${one.reason}`));
  return [news.length ? table(news) : h('p', {}, 'No parameter changes significantly.'),
    (rest.length || unsaid.length) && h('details', { class: 'small' }, h('summary', {}, `Kept as they are (${rest.length + unsaid.length})`),
      rest.length && table(rest), h('ul', {}, unsaid))];
}

/** The difference, and the choice: nothing is written before it was seen. */
function proposed(text, label, sure, write) {
  const leave = () => {
    removal = null;
    state.trial = null;
    changed('trial');
  };
  return [h('p', { class: 'small muted' }, `What changes in ${state.model}:`), difference(text),
    h('div', { class: 'row-line' }, h('button', { class: sure ? 'main' : '', id: 'write', onclick: write }, label),
      h('button', { class: 'quiet', id: 'drop', onclick: leave }, 'Leave it'))];
}

export function draw() {
  const { trial } = state;
  if (trial || removal?.model !== state.model) removal = null;
  byId('addition').hidden = !trial && !removal && written?.model !== state.model;
  if (!trial) {
    const now = removal ?? written;
    if (shown === now) return;
    shown = now;
    if (removal) {
      const going = removal;
      return fill('addition', h('h2', {}, `Without ${going.effect}`),
        proposed(going.difference, 'Take it out', true, () => writeRemoval(going)));
    }
    return fill('addition', written && [h('h2', {}, 'Written'), h('p', { class: 'good', id: 'added' }, `✓ ${written.what} in ${written.model}.`),
      h('button', { id: 'undo', onclick: undo }, 'Undo')]);
  }
  shown = undefined;
  fill('addition', h('h2', {}, `With ${trial.label}`), fall(trial), here(), trial.undetermined && fitted(trial),
    trial.doubt && h('p', { class: 'bad', id: 'doubt' }, trial.doubt),
    trial.difference
      ? proposed(trial.difference, `${trial.undetermined ? 'Write' : 'Add'} ${trial.doubt ? 'it all the same' : 'to the model'}`,
        !trial.doubt, () => write(trial, Boolean(trial.doubt)))
      : h('p', {}, 'There is nothing to add.'));
}
