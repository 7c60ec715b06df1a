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

/** The shift of the second run, s, with the least mean square of the difference; at least half of the shorter run overlaps. */
export function bestShift([time, measured], [otherTime, other]) {
  const every = Math.max(1, Math.ceil(time.length / 2000));
  const at = time.filter((_, n) => n % every === 0);
  const values = measured.filter((_, n) => n % every === 0);
  const last = (times) => times[times.length - 1] - times[0];
  const most = Math.min(last(time), last(otherTime)) / 2;
  const offset = time[0] - otherTime[0];
  const cost = (shift) => {
    const second = interpolated(otherTime, other, at, shift);
    let [sum, count] = [0, 0];
    for (let n = 0; n < at.length; n++) {
      if (Number.isNaN(second[n]) || Number.isNaN(values[n])) continue;
      sum += (values[n] - second[n]) ** 2;
      count++;
    }
    return count ? sum / count : Infinity;
  };
  const least = (from, to, step) => {
    let best = [Infinity, 0];
    for (let shift = from; shift <= to; shift += step) {
      const now = cost(shift);
      if (now < best[0]) best = [now, shift];
    }
    return best[1];
  };
  const coarse = most / 300;
  const near = least(offset - most, offset + most, coarse);
  return least(near - coarse, near + coarse, (time[1] - time[0]) / 4);
}
