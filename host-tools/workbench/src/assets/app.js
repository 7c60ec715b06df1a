// The workbench: what belongs to what, and the keyboard.

import { session } from './api.js';
import * as add from './add.js';
import * as diagnosis from './diagnosis.js';
import { byId, fill, h, trouble } from './dom.js';
import * as folder from './folder.js';
import * as history from './history.js';
import * as hypothesis from './hypothesis.js';
import * as live from './live.js';
import * as plots from './plots.js';
import * as simulation from './simulation.js';
import { on, state } from './state.js';
import * as verdict from './verdict.js';

on('look', () => verdict.compare());
on('look', () => history.draw());
on('look diagnosis trial', () => add.draw());
on('look selection', () => diagnosis.draw());
on('selection', () => diagnosis.ask());
on('axis overlay', () => plots.load());
on('trial', async () => {
  await plots.load();
  add.draw();
  diagnosis.draw();
  if (state.trial) byId('addition').scrollIntoView({ block: 'nearest', behavior: 'smooth' });
});
on('folder', () => folder.draw());
on('read', () => simulation.load());

/** Keys, what they do, and how that is called. */
const KEYS = {
  d: ['Diagnose', diagnosis.diagnose],
  Escape: ['End a diagnosis', diagnosis.cancel],
  j: ['Next failing axis', () => verdict.step(1)],
  k: ['Previous failing axis', () => verdict.step(-1)],
  n: ['Next failing window', () => plots.stepWindow(1)],
  p: ['Previous failing window', () => plots.stepWindow(-1)],
  ArrowLeft: ['Earlier', () => plots.linked.pan(-0.2)],
  ArrowRight: ['Later', () => plots.linked.pan(0.2)],
  '+': ['Closer', () => plots.linked.zoom(0.6)],
  '-': ['Further away', () => plots.linked.zoom(1 / 0.6)],
  0: ['The whole recording', () => plots.linked.whole()],
  '[': ['Second run one cycle earlier', () => plots.nudge(-1)],
  ']': ['Second run one cycle later', () => plots.nudge(1)],
  t: ['Dark or light', theme],
  '?': ['This list', help],
};

function theme() {
  const dark = getComputedStyle(document.documentElement).getPropertyValue('color-scheme').includes('dark');
  document.documentElement.dataset.theme = dark ? 'light' : 'dark';
  plots.draw();
}

function help() {
  const rows = Object.entries(KEYS).map(([key, [what]]) => h('tr', {}, h('td', {}, h('kbd', {}, key)), h('td', {}, what)));
  fill('help', h('h2', {}, 'Keyboard'), h('table', {}, rows), h('p', { class: 'small muted' }, 'Plots: ', h('a', { href: '/assets/uPlot.LICENSE' }, 'uPlot 1.6.32, MIT')),
    h('form', { method: 'dialog' }, h('button', { class: 'main' }, 'Close')));
  byId('help').showModal();
}

document.addEventListener('keydown', (event) => {
  const typing = event.target.closest?.('input, textarea, select, dialog');
  if (typing || event.ctrlKey || event.metaKey || event.altKey || !KEYS[event.key]) return;
  event.preventDefault();
  KEYS[event.key][1]();
});
byId('keys').addEventListener('click', help);
byId('theme').addEventListener('click', theme);
new ResizeObserver(() => plots.linked.resize()).observe(byId('plots'));
new ResizeObserver(() => live.resize()).observe(byId('live'));
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => plots.draw());
window.addEventListener('unhandledrejection', (event) => trouble(event.reason?.message ?? String(event.reason)));

const about = await session();
byId('root').textContent = about.root;
byId('root').title = `${about.root} · ${about.version}`;
hypothesis.draw();
live.begin(about.live);
await folder.reload();
await simulation.load();
await Promise.all([verdict.compare(), history.draw(), diagnosis.ask()]);
document.body.dataset.ready = String(Boolean(state));
