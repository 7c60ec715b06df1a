// A running board, to look at: mode, force and velocity of the last seconds, counters, and how long its answers took.

import { post } from './api.js';
import { Linked } from './chart.js';
import { byId, fill, h, trouble } from './dom.js';

/** What is shown of the past, s. */
const SECONDS = 20;
/** Time from one drawing to the next, ms. */
const REDRAW = 80;

let events = null;
let frame = null;
let dropped = 0;
let due = false;
/** Time, then force x y z, then velocity x y z, of the cycles that are shown. */
let past = Array.from({ length: 7 }, () => []);

const plots = new Linked({ windows: () => [], picked: () => {} });
const words = (name) => name.replace(/([a-z])([A-Z])/g, '$1 $2').toLowerCase();

/** Follows the board whose telemetry comes to an address of this computer. */
async function start(listen) {
  try {
    const { listen: address } = await post('live/start', { listen });
    trouble(null);
    follow(address);
  } catch (error) {
    trouble(error.message);
  }
}

function follow(address) {
  events?.close();
  past = past.map(() => []);
  [frame, dropped] = [null, 0];
  events = new EventSource('/api/live');
  events.addEventListener('frame', (event) => take(JSON.parse(event.data)));
  events.addEventListener('dropped', (event) => { dropped += Number(event.data); });
  draw(address);
}

async function stop() {
  events?.close();
  events = null;
  await post('live/stop', {}).catch(() => {});
  plots.clear();
  draw(null);
}

function take(next) {
  frame = next;
  const rows = next.time_s.map((time, n) => [time, ...next.force_n[n], ...next.velocity_m_s[n]]);
  for (const row of rows) {
    if (past[0].length && row[0] <= past[0].at(-1)) past = past.map(() => []);
    past.forEach((column, k) => column.push(row[k]));
  }
  const old = past[0].findIndex((time) => time > (past[0].at(-1) ?? 0) - SECONDS);
  if (old > 0) past.forEach((column) => column.splice(0, old));
  if (due) return;
  due = true;
  setTimeout(() => {
    due = false;
    if (events) show();
  }, REDRAW);
}

function histogram({ histogram: counts, last_us: last, longest_us: longest }) {
  const most = Math.max(...counts, 1);
  const bar = (count, k) => h('i', {
    class: k === counts.length - 1 && count ? 'late' : '', style: { height: `${count ? Math.max(100 * Math.log1p(count) / Math.log1p(most), 4) : 0}%` },
    title: `${count} answers ${k === counts.length - 1 ? 'took longer than a cycle' : `took ${k}/16 to ${k + 1}/16 of a cycle`}`,
  });
  return [h('p', { class: 'small muted' }, `Answers: last ${last} µs, longest ${longest} µs; by sixteenths of a cycle, the last bar is late`),
    h('div', { class: 'histogram', role: 'img', 'aria-label': 'How long answers took' }, counts.map(bar))];
}

function show() {
  const { mode, fault, refusal, losses, silent_s: silent } = frame;
  const quiet = !past[0].length || silent > 1;
  const counter = (name, value, bad) => h('div', {}, h('span', { class: 'small muted' }, name), h('strong', { class: bad ? 'bad' : '' }, String(value)));
  fill('live-state',
    h('p', { class: 'mode', 'data-mode': mode ?? '' }, quiet
      ? h('span', { class: 'muted' }, past[0].length ? `Silent for ${Math.round(silent)} s` : 'Waiting for a board …')
      : [h('strong', { class: fault ? 'bad' : mode === 'Running' ? 'good' : '' }, words(mode)), fault && h('span', { class: 'bad' }, ` ${fault}`)]),
    refusal && h('p', { class: 'small' }, `Refused last: ${refusal}`),
    frame.firmware && h('p', { class: 'small muted' }, frame.firmware),
    h('div', { class: 'counters' }, counter('cycle', frame.cycle.toLocaleString('en')), counter('sensor age', `${frame.sensor_age} cycles`, frame.sensor_age > 2),
      counter('late answers', frame.late_answers, frame.late_answers), counter('lost on the board', losses[0], losses[0]),
      counter('lost by the network', losses[1], losses[1]), counter('not readable', losses[2], losses[2]), dropped ? counter('frames not drawn', dropped) : null),
    frame.answers && histogram(frame.answers));
  if (past[0].length < 2) return;
  if (!plots.plots.length) addPlots();
  plots.plots.forEach((plot, k) => plot.setData([past[0], ...past.slice(1 + 3 * k, 4 + 3 * k).map((one) => (k ? one.map((v) => 1000 * v) : one))]));
}

function addPlots() {
  const colours = ['blue', 'vermilion', 'green'];
  const series = (from) => ['x', 'y', 'z'].map((label, k) => ({ label, values: past[from + k], colour: colours[k] }));
  plots.add(byId('live-plots'), 150, { time: past[0], series: series(1), unit: 'N', label: 'force' });
  plots.add(byId('live-plots'), 150, { time: past[0], series: series(4), unit: 'm/s', label: 'velocity' });
}

export function resize() {
  plots.resize();
}

/** `address`: where it is listened, if it is. */
export function draw(address) {
  const form = h('form', { onsubmit: (event) => { event.preventDefault(); start(new FormData(event.target).get('listen').trim()); } },
    h('label', {}, h('span', { class: 'small muted' }, 'UDP address to which the board sends its telemetry'),
      h('input', { name: 'listen', value: '0.0.0.0:49200', required: true, 'aria-label': 'UDP address' })),
    h('button', { id: 'watch' }, 'Watch'));
  const following = [h('div', { class: 'row-line' }, h('span', { class: 'small muted' }, `Listening on UDP ${address}`),
    h('button', { class: 'quiet', onclick: stop }, 'Stop watching')),
  h('div', { id: 'live-state' }, h('p', { class: 'muted' }, 'Waiting for a board …')), h('div', { id: 'live-plots' })];
  fill('live', h('details', { open: Boolean(address) }, h('summary', {}, h('h2', {}, 'Live board')),
    h('p', { class: 'small muted' }, 'To look at only: the browser never arms, starts or moves anything.'), address ? following : form));
}

/** Goes on with what the server listens to already. */
export function begin(address) {
  if (address) follow(address);
  else draw(null);
}
