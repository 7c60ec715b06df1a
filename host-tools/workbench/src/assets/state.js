// What the page shows, and who wants to know when it changes.

export const state = {
  models: [],
  recordings: [],
  /** Ids of what is looked at. */
  model: null,
  recording: null,
  /** Ids of recordings by what a diagnosis does with them. */
  fit: new Set(),
  test: new Set(),
  /** A second run over the first: its id, and by how much it is later, s. */
  overlay: { id: null, shift: 0 },
  /** The model file: id, text, if_match, model. */
  file: null,
  comparison: null,
  channel: null,
  axis: null,
  /** A recorded column that is drawn below: name, unit. */
  column: null,
  /** A hypothesis that is tried: job, label, and what `add` would say. */
  trial: null,
  /** A diagnosis: its job and what it says. */
  diagnosis: null,
};

const listeners = new Map();

export function on(what, does) {
  for (const one of what.split(' ')) listeners.set(one, [...(listeners.get(one) ?? []), does]);
}

export function changed(what) {
  for (const does of listeners.get(what) ?? []) does();
}

/** The failure of an axis, if the model fails there. */
export const failureOf = (channel, axis) =>
  state.comparison?.failures.find((one) => one.channel === channel && one.axis === axis);

/** Windows of the phases in which an axis fails; without a failure there are none. */
export function failingWindows(channel, axis) {
  const failure = failureOf(channel, axis);
  if (!failure) return [];
  const named = new Set(failure.phases.map((one) => one.phase));
  const phases = state.comparison.phases.filter((one) => named.has(one.name));
  const windows = phases.flatMap((one) => one.windows.map((window) => ({ ...window, phase: one.name })));
  return windows.sort((a, b) => a.from_s - b.from_s);
}

/** Effects that the model has. */
export const effectsOfModel = () => state.file?.model.effect ?? [];

/** What a diagnosis works with. */
export const selection = () => ({ model: state.model, fit: [...state.fit], test: [...state.test] });
