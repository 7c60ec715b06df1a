// Two plots with one time axis: what was measured and predicted, and the difference.

import { scaled } from './dom.js';

const uPlot = window.uPlot;
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** uPlot takes null for a gap; what has none stays as it came. */
const gaps = (values) => (values.some(Number.isNaN) ? Array.from(values, (v) => (Number.isNaN(v) ? null : v)) : values);

/** Room for the numbers of an axis. */
const widest = (_, texts) => Math.max(62, 26 + 7.5 * Math.max(...(texts ?? []).map((text) => text?.length ?? 0)));

/** Plots whose time axes are one. */
export class Linked {
  constructor({ windows, picked }) {
    this.plots = [];
    this.windows = windows;
    this.picked = picked;
    this.range = null;
  }

  clear() {
    this.plots.forEach((plot) => plot.destroy());
    this.plots = [];
  }

  /** Draws `series` ({label, values, colour, dash, fill}) over `time` into an element. */
  add(element, height, { time, series, unit, label }) {
    const { factor, unit: said } = scaled(unit);
    const scale = (values) => gaps(factor === 1 ? values : values.map((v) => v * factor));
    const options = {
      width: element.clientWidth, height,
      cursor: { sync: { key: 'time' }, drag: { x: true, y: false }, focus: { prox: 30 }, points: { size: 6 } },
      legend: { live: true },
      scales: { x: { time: false }, y: { range: (_, low, high) => (low === null ? [-1, 1] : uPlot.rangeNum(low, high, 0.08, true)) } },
      axes: [this.axis('time [s]', { size: 42 }), this.axis(`${label} [${said}]`, { size: widest })],
      series: [{ label: 's', value: (_, v) => (v === null ? '–' : v.toFixed(3)) }, ...series.map((one) => ({
        label: one.label, class: one.silent ? 'silent' : undefined, stroke: css(one.colour), width: one.width ?? 1.4, dash: one.dash, points: { show: false },
        value: (_, v) => (v === null || v === undefined ? '–' : `${v.toPrecision(4)} ${said}`),
      }))],
      bands: series.flatMap((one, k) => (one.fill ? [{ series: [k + 1, k + 2], fill: css(one.fill) }] : [])),
      hooks: {
        drawClear: [(plot) => this.shade(plot)],
        setScale: [(plot, key) => key === 'x' && this.follow(plot)],
        ready: [(plot) => this.listen(plot)],
      },
    };
    this.plots.push(new uPlot(options, [time, ...series.map((one) => scale(one.values))], element));
    if (this.range) this.plots.at(-1).setScale('x', this.range);
  }

  axis(label, more) {
    const font = '12px system-ui, sans-serif';
    return {
      label, labelFont: font, font, labelSize: 18, stroke: css('muted'), ...more,
      grid: { stroke: css('grid'), width: 1 }, ticks: { stroke: css('grid'), width: 1 },
    };
  }

  /** Shades the windows in the colours of their phases; the one that was picked, more. */
  shade(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    for (const window of this.windows()) {
      const from = Math.max(plot.valToPos(window.from_s, 'x', true), bbox.left);
      const to = Math.min(plot.valToPos(window.to_s, 'x', true), bbox.left + bbox.width);
      if (to < bbox.left || from > bbox.left + bbox.width) continue;
      // Free flight may be most of the time.
      const faint = window.phase === 'free_flight' ? 0.5 : 1;
      ctx.globalAlpha = (window.picked ? 0.34 : 0.15) * faint * (css('shade') || 1);
      ctx.fillStyle = css(`phase-${window.phase}`);
      ctx.fillRect(from, bbox.top, Math.max(to - from, 1.5), bbox.height);
    }
    ctx.restore();
  }

  /** All plots show the range of one. */
  follow(plot) {
    const { min, max } = plot.scales.x;
    if (min === undefined || (this.range && this.range.min === min && this.range.max === max)) return;
    this.range = { min, max };
    for (const other of this.plots) {
      if (other !== plot && (other.scales.x.min !== min || other.scales.x.max !== max)) other.setScale('x', { min, max });
    }
  }

  listen(plot) {
    let pressed = null;
    plot.over.addEventListener('mousedown', (event) => { pressed = event.clientX; });
    plot.over.addEventListener('click', (event) => {
      if (pressed !== null && Math.abs(event.clientX - pressed) > 4) return;
      this.picked(plot.posToVal(event.offsetX, 'x'), event);
    });
    plot.over.addEventListener('dblclick', () => this.whole());
    plot.over.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoom(event.deltaY > 0 ? 1.25 : 0.8, plot.posToVal(event.offsetX, 'x'));
    }, { passive: false });
  }

  /** Changes the range about a place, by default the middle. */
  zoom(factor, about) {
    const { min, max } = this.shown();
    const centre = about ?? (min + max) / 2;
    this.show(centre - (centre - min) * factor, centre + (max - centre) * factor);
  }

  /** Moves the range by a share of its length. */
  pan(share) {
    const { min, max } = this.shown();
    this.show(min + share * (max - min), max + share * (max - min));
  }

  shown() {
    return this.plots[0]?.scales.x ?? { min: 0, max: 1 };
  }

  /** Shows a range, as far as there are data. */
  show(min, max) {
    const time = this.plots[0]?.data[0];
    if (!time?.length) return;
    const [first, last] = [time[0], time[time.length - 1]];
    const length = Math.min(Math.max(max - min, 4 * (last - first) / time.length), last - first);
    const from = Math.min(Math.max(min, first), last - length);
    this.plots[0].setScale('x', { min: from, max: from + length });
  }

  whole() {
    this.show(-Infinity, Infinity);
    const time = this.plots[0]?.data[0];
    if (time?.length) this.plots[0].setScale('x', { min: time[0], max: time[time.length - 1] });
  }

  redraw() {
    this.plots.forEach((plot) => plot.redraw(false));
  }

  resize() {
    for (const plot of this.plots) plot.setSize({ width: plot.root.parentElement.clientWidth, height: plot.height });
  }
}
