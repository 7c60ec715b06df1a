// Where the model fails: the sentence, the phases, and the error of every channel and axis.

import { post } from './api.js';
import { fill, h, percent, quantity, significant, trouble, words } from './dom.js';
import { changed, failureOf, state } from './state.js';

/** Compares the model with the recording that is looked at. */
export async function compare() {
  state.comparison = null;
  if (!state.model || !state.recording) return draw();
  const asked = [state.model, state.recording];
  fill('verdict', h('p', { class: 'muted' }, 'Comparing …'));
  try {
    const comparison = await post('compare', { model: asked[0], recording: asked[1] });
    if (asked[0] !== state.model || asked[1] !== state.recording) return;
    state.comparison = comparison;
    trouble(null);
  } catch (error) {
    if (asked[0] !== state.model || asked[1] !== state.recording) return;
    fill('verdict', h('p', { class: 'sentence bad' }, error.message));
    // Curves of another recording would stand under the message.
    changed('axis');
    return;
  }
  const known = state.comparison.channels.some((one) => one.name === state.channel && one.axis === state.axis);
  if (!known) chooseAxis();
  draw();
  changed('axis');
}

/** The worst failure, or the largest error. */
function chooseAxis() {
  const { failures, channels } = state.comparison;
  const largest = [...channels].sort((a, b) => b.rms_expected_sigma - a.rms_expected_sigma)[0];
  [state.channel, state.axis] = failures.length
    ? [failures[0].channel, failures[0].axis] : [largest?.name, largest?.axis];
}

export function look(channel, axis) {
  Object.assign(state, { channel, axis });
  draw();
  changed('axis');
}

/** The failing axis that many places after this one. */
export function step(places) {
  const { failures = [], channels = [] } = state.comparison ?? {};
  const list = failures.length ? failures.map((one) => [one.channel, one.axis]) : channels.map((one) => [one.name, one.axis]);
  const now = list.findIndex(([channel, axis]) => channel === state.channel && axis === state.axis);
  if (list.length) look(...list[(now + places + list.length) % list.length]);
}

function axisButton(one) {
  const fails = failureOf(one.name, one.axis);
  return h('button', {
    class: `axis${fails ? ' fails' : ''}`, 'aria-pressed': one.name === state.channel && one.axis === state.axis,
    'data-axis': `${one.name} ${one.axis}`, onclick: () => look(one.name, one.axis),
    title: `${quantity(one.rms, one.unit)} rms, ${significant(one.rms_expected_sigma)} times the expected noise`,
  }, h('span', {}, one.axis), h('span', { class: 'small' }, `${one.rms_expected_sigma < 0.01 ? '0' : significant(one.rms_expected_sigma, 2)} σ`));
}

function channels() {
  const names = [...new Set(state.comparison.channels.map((one) => one.name))];
  return h('div', { class: 'channels' }, names.map((name) => h('div', { class: 'channel' },
    h('span', { class: 'muted small label' }, words(name)),
    h('div', { class: 'axes' }, state.comparison.channels.filter((one) => one.name === name).map(axisButton)))));
}

/** One bar of what exceeds the noise, a colour for each phase. */
function phases() {
  const there = state.comparison.phases.filter((one) => one.share_beyond_noise > 0.005);
  if (!there.length) return null;
  const part = (one) => h('i', {
    class: `phase-${one.name}`, style: { flexGrow: one.share_beyond_noise }, title: `${words(one.name)}: ${percent(one.share_beyond_noise)}`,
  });
  const label = (one) => h('span', { class: 'small' }, h('i', { class: `dot phase-${one.name}` }),
    `${words(one.name)} ${percent(one.share_beyond_noise)}`);
  return h('div', { class: 'phases', title: 'Shares of the error beyond the noise' },
    h('div', { class: 'bar' }, there.map(part)), h('div', { class: 'legend' }, there.map(label)));
}

/** The first sentence large, the rest below. */
function sentence(text) {
  const end = text.search(/[^0-9]\. /);
  const [first, rest] = end < 0 ? [text, ''] : [text.slice(0, end + 2), text.slice(end + 3)];
  return [h('p', { class: `sentence ${state.comparison.at_noise ? 'good' : ''}` },
    h('span', { class: 'mark', 'aria-hidden': 'true' }, state.comparison.at_noise ? '✓ ' : '✗ '), first), rest && h('p', { class: 'rest' }, rest)];
}

export function draw() {
  if (!state.comparison) {
    fill('verdict', h('p', { class: 'sentence' }, state.model
      ? 'Choose a recording to hold against the model.' : 'Choose a model and a recording.'));
    return;
  }
  const notes = state.comparison.notes;
  fill('verdict', h('p', { class: 'muted small' }, `${state.model} against ${state.recording}`),
    sentence(state.comparison.where), phases(), channels(),
    notes.length && h('details', { class: 'small muted' }, h('summary', {}, `${notes.length} note${notes.length > 1 ? 's' : ''} on the recording`),
      h('ul', {}, notes.map((note) => h('li', {}, note)))));
}
