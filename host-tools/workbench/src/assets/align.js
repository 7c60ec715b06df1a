// Two runs on one time axis.

/** Values of a series at other times, where it is `shift` later; NaN outside of it. */
export function interpolated(time, values, at, shift) {
  const found = new Float64Array(at.length);
  let k = 0;
  for (let n = 0; n < at.length; n++) {
    const t = at[n] - shift;
    while (k + 2 < time.length && time[k + 1] < t) k++;
    const share = (t - time[k]) / (time[k + 1] - time[k]);
    found[n] = t < time[0] || t > time[time.length - 1] ? NaN : values[k] + share * (values[k + 1] - values[k]);
  }
  return found;
}

/** Grid points of both runs together: two of a quarter of an hour keep each cycle. */
const MOST = 2 ** 19;

let [known, tables] = [0, null];
/** Cosines and sines of a transform; the same for all of a search. */
function turns(count) {
  const table = (of) => Float64Array.from({ length: count / 2 }, (_, k) => of(-2 * Math.PI * k / count));
  if (known !== count) [known, tables] = [count, [table(Math.cos), table(Math.sin)]];
  return tables;
}

/** Fourier transform of complex numbers in place, a power of two of them; with real and imaginary part exchanged the way back, without the scale. */
function transform(re, im) {
  const count = re.length;
  for (let n = 1, other = 0; n < count; n++) {
    let bit = count / 2;
    for (; other & bit; bit >>= 1) other ^= bit;
    other ^= bit;
    if (n < other) [re[n], re[other], im[n], im[other]] = [re[other], re[n], im[other], im[n]];
  }
  const [cos, sin] = turns(count);
  for (let half = 1; half < count; half *= 2) {
    for (let first = 0; first < count; first += 2 * half) {
      for (let k = 0; k < half; k++) {
        const [low, high, turn] = [first + k, first + k + half, k * (count / 2 / half)];
        const x = re[high] * cos[turn] - im[high] * sin[turn];
        const y = re[high] * sin[turn] + im[high] * cos[turn];
        re[high] = re[low] - x;
        im[high] = im[low] - y;
        re[low] += x;
        im[low] += y;
      }
    }
  }
}

/** Values, their squares and where there are any, on a grid with zeros behind, transformed. */
function spectra(time, values, step, rest, length) {
  const at = Float64Array.from({ length: Math.floor((time[time.length - 1] - time[0]) / step) + 1 }, (_, n) => time[0] + n * step);
  const found = interpolated(time, values, at, 0).map((value) => value - rest);
  const spectrum = (of) => {
    const [re, im] = [new Float64Array(length), new Float64Array(length)];
    found.forEach((value, n) => { if (!Number.isNaN(value)) re[n] = of(value); });
    transform(re, im);
    return [re, im];
  };
  return { count: at.length, values: spectrum((v) => v), squares: spectrum((v) => v * v), there: spectrum(() => 1) };
}

/** For each shift of the second by whole steps: the sum of products of two series, of all pairs together. */
function correlation(pairs, length) {
  const [re, im] = [new Float64Array(length), new Float64Array(length)];
  for (const [[aRe, aIm], [bRe, bIm]] of pairs) {
    for (let k = 0; k < length; k++) {
      re[k] += (aRe[k] * bRe[k] + aIm[k] * bIm[k]) / length;
      im[k] += (aIm[k] * bRe[k] - aRe[k] * bIm[k]) / length;
    }
  }
  transform(im, re);
  return re;
}

/** The shift of the second run, s, with the least difference, as a part of what both runs have in the overlap: a rest laid over a rest
 * differs little, and says nothing. At least half of the shorter run overlaps; null where it has not as many values. */
export function bestShift([time, measured], [otherTime, other]) {
  const last = (times) => times[times.length - 1] - times[0];
  const cycle = last(time) / (time.length - 1);
  const step = Math.max(cycle, (last(time) + last(otherTime)) / (MOST - 2));
  const length = 2 ** Math.ceil(Math.log2((last(time) + last(otherTime)) / step + 2));
  // Counted from rest, where a run is most of the time: two rests that are far from zero would go together best.
  const sorted = measured.filter((value) => !Number.isNaN(value)).sort();
  const rest = sorted[sorted.length >> 1];
  const [one, two] = [spectra(time, measured, step, rest, length), spectra(otherTime, other, step, rest, length)];
  const products = correlation([[one.values, two.values]], length);
  const squares = correlation([[one.squares, two.there], [one.there, two.squares]], length);
  const counts = correlation([[one.there, two.there]], length);
  const least = Math.min(one.count, two.count) / 2;
  // Below, sums are what rounding leaves of zero.
  const some = 1e-9 * squares.reduce((a, b) => Math.max(a, b));
  let [best, near] = [-Infinity, 0];
  for (let lag = 1 - two.count; lag < one.count; lag++) {
    const place = (lag + length) % length;
    // Σ(a − b)² / Σ(a² + b²) is least where this is largest.
    const now = products[place] / squares[place];
    if (counts[place] > least - 0.5 && squares[place] > some && now > best) [best, near] = [now, lag];
  }
  if (best === -Infinity) return null;
  const cost = (shift) => {
    const second = interpolated(otherTime, other, time, shift);
    let [sum, whole] = [0, 0];
    for (let n = 0; n < time.length; n++) {
      if (Number.isNaN(second[n]) || Number.isNaN(measured[n])) continue;
      sum += (measured[n] - second[n]) ** 2;
      whole += (measured[n] - rest) ** 2 + (second[n] - rest) ** 2;
    }
    return whole ? sum / whole : Infinity;
  };
  const from = time[0] - otherTime[0] + near * step;
  const shifts = Array.from({ length: 9 }, (_, k) => from + (k - 4) / 4 * step);
  return shifts.map((shift) => [cost(shift), shift]).reduce((a, b) => (b[0] < a[0] ? b : a))[1];
}
