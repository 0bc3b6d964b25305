// Charts over the time of the log; all of them show the same times.

/** Steps between the times on an axis [s]. */
const kTimeSteps = [0.001, 0.01, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 28800, 86400, 604800];

class Charts {
  /** `onTime(t or null)`, `onWindow([from, to] or null)`: what the pointer is at, what is shown. */
  constructor(data, onTime, onWindow) {
    this.data = data;
    this.onTime = onTime;
    this.onWindow = onWindow;
    this.all = [];
    this.end = Math.max(data.duration_s ?? 0, data.track.t.at(-1) ?? 0, 1e-3);
  }

  /**
   * A chart: `series` [{name, values, tint, width, dots}], `band` {low, high}: lists with a filled area in between,
   * `logarithmic`, `unit`. Returns its card.
   */
  add({ title, note, t, series, band, unit = '', logarithmic = false, range }) {
    const at = el('span', { class: 'at' });
    const card = el('div', { class: 'card chart' }, el('h3', {}, title, note ? el('small', {}, note) : null, at));
    this.all.push({ card, at, spec: { t, series, band, unit, logarithmic, range }, plot: null });
    return card;
  }

  /** Draws the charts once their cards are in the page, and again when the page changes. */
  drawAll() {
    for (const chart of this.all) {
      chart.plot?.destroy();
      chart.plot = this.plotOf(chart);
    }
    if (this.window) this.show(this.window);
  }

  resize() {
    for (const { plot, card } of this.all) plot.setSize({ width: card.clientWidth - 24, height: plot.height });
  }

  plotOf({ card, at, spec }) {
    const { t, series, band, unit, logarithmic, range } = spec;
    const axis = {
      stroke: color('soft'),
      font: '11px ' + color('sans'),
      grid: { stroke: color('grid'), width: 1 },
      ticks: { show: false },
    };
    const data = [t, ...series.map((s) => s.values)];
    const lines = series.map((s) => ({
      label: s.name,
      stroke: s.tint ? color(s.tint) : 'transparent',
      width: s.width ?? 1.4,
      dash: s.dash,
      spanGaps: s.spanGaps ?? false,
      points: { show: s.dots ?? false, size: 4, width: 0, fill: s.tint ? color(s.tint) : undefined },
      paths: s.onlyDots ? () => null : undefined,
    }));
    const bands = [];
    if (band) {
      data.push(band.high, band.low);
      const edge = { stroke: 'transparent', width: 0, points: { show: false } };
      lines.push({ ...edge, label: 'high' }, { ...edge, label: 'low' });
      bands.push({ series: [data.length - 2, data.length - 1], fill: color('band') });
    }
    const options = {
      width: card.clientWidth - 24,
      height: 178,
      legend: { show: false },
      padding: [8, 16, 0, 0],
      cursor: { sync: { key: 'run', scales: ['x', null] }, drag: { x: true, y: false }, y: false, points: { size: 6 } },
      scales: {
        x: { time: false, range: (u, low, high) => (low == null || low === high ? [0, this.end] : [low, high]) },
        y: logarithmic ? { distr: 3, range: range ?? undefined } : { range: range ?? ((u, low, high) => this.niceRange(low, high)) },
      },
      axes: [
        { ...axis, size: 26, incrs: kTimeSteps, values: (u, splits) => splits.map((s) => clock(s, splits[1] - splits[0] < 1 ? 1 : 0)), space: 65 },
        { ...axis, size: 56, space: 34, values: (u, splits) => splits.map((s) => (s == null ? '' : logarithmic ? digits(s, 1) : tick(s, splits))) },
      ],
      series: [{}, ...lines],
      bands,
      hooks: {
        drawClear: [(u) => this.shadeOutages(u)],
        setSelect: [(u) => this.selected(u)],
        setCursor: [(u) => this.moved(u)],
        ready: [(u) => u.over.addEventListener('dblclick', () => this.show(null))],
      },
    };
    options.cursor.bind = { dblclick: () => () => {} };
    options.cursor.drag.setScale = false;
    const plot = new uPlot(options, data, card);
    plot.at = { element: at, series, unit };
    return plot;
  }

  niceRange(low, high) {
    if (low == null) return [-1, 1];
    const margin = Math.max((high - low) * 0.08, Math.abs(high) * 1e-6, 1e-9);
    return [low - margin, high + margin];
  }

  shadeOutages(u) {
    const { left, top, width, height } = u.bbox;
    u.ctx.save();
    u.ctx.fillStyle = color('outage');
    for (const outage of this.data.outages) {
      const from = Math.max(u.valToPos(outage.from, 'x', true), left);
      const to = Math.min(u.valToPos(outage.to, 'x', true), left + width);
      if (to > from) u.ctx.fillRect(from, top, Math.max(to - from, 1), height);
    }
    u.ctx.restore();
  }

  /** A drag over a chart: all of them show those times. */
  selected(u) {
    if (!(u.select.width > 3)) return;
    const window = [u.posToVal(u.select.left, 'x'), u.posToVal(u.select.left + u.select.width, 'x')];
    u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    if (!this.isShowing) this.show(window);
  }

  /** The charts show these times; null: all. */
  show(window) {
    this.isShowing = true;
    this.window = window;
    const [min, max] = window ?? [0, this.end];
    for (const { plot } of this.all) plot?.setScale('x', { min, max });
    this.isShowing = false;
    this.onWindow(window);
  }

  moved(u) {
    const index = u.cursor.idx;
    for (const { plot } of this.all) if (plot) this.readOff(plot);
    if (this.isPlaced) return;
    this.onTime(index == null || u.cursor.left < 0 ? null : u.posToVal(u.cursor.left, 'x'));
  }

  readOff(plot) {
    const { element, series, unit } = plot.at;
    const index = plot.cursor.idx;
    const shown = series.filter((s) => s.name);
    element.textContent = index == null ? '' : shown
      .map((s) => `${shown.length > 1 ? s.name + ' ' : ''}${digits(s.values[index])}`).join('  ') + (unit ? ' ' + unit : '');
  }

  /** Puts the cursor of all charts at a time; null: nowhere. */
  showTime(time) {
    this.isPlaced = true;
    for (const { plot } of this.all) {
      plot.setCursor({ left: time == null ? -10 : plot.valToPos(time, 'x'), top: time == null ? -10 : 5 }, false);
      plot.cursor.idx = time == null ? null : plot.posToIdx(plot.valToPos(time, 'x'));
      this.readOff(plot);
    }
    this.isPlaced = false;
  }
}

/** A number on an axis, with as many decimals as the step between two of them needs. */
function tick(value, splits) {
  const there = splits.filter((s) => s != null);
  const step = there.length > 1 ? Math.abs(there[1] - there[0]) : Math.abs(value);
  let decimals = 0;
  while (decimals < 9 && Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-3) ++decimals;
  if (step < 1e-5 && value !== 0) return value.toExponential(1).replace('-', '−');
  return value.toFixed(decimals).replace('-', '−');
}

// --- what is drawn over time ---

/** Rounding and full turns aside: an angle within half a turn. */
const wrapped = (degrees) => degrees - 360 * Math.round(degrees / 360);

/** Angles with a gap where they pass half a turn, so that no line crosses the chart there. */
const unwoven = (angles) => angles.map((a, i) => (i > 0 && Math.abs(a - angles[i - 1]) > 180 ? null : a));

/** Difference of two columns; null where one is. */
const minus = (a, b, wrap = (d) => d) => a.map((value, i) => (value == null || b[i] == null ? null : wrap(value - b[i])));

/** The charts of pose and error: what there is a reference for as an error, the rest with its σ. */
function addPoseCharts(charts, data) {
  const { track, reference } = data;
  const cards = [];
  const at = reference?.at_track;
  const has = (column) => at?.[column]?.some((value) => value != null);
  const pose = [['x', 'East', 'sx', 'm'], ['y', 'North', 'sy', 'm']];
  if (data.spatial) pose.push(['z', 'Up', 'sz', 'm'], ['roll', 'Roll', 'sroll', '°'], ['pitch', 'Pitch', 'spitch', '°']);
  pose.push(['yaw', 'Heading', 'syaw', '°']);
  for (const [column, name, sigma, unit] of pose) {
    const isAngle = unit === '°';
    const isComparable = has(column) && (!isAngle || reference.has_yaw);
    const three = track[sigma].map((s) => (s == null ? null : 3 * s));
    if (isComparable) {
      const error = minus(track[column], at[column], isAngle ? wrapped : undefined);
      cards.push(charts.add({
        title: `${name}: error`, note: `±3σ shaded, ${unit}`, t: track.t, unit,
        series: [{ name: 'error', values: error, tint: 'reference' }],
        band: { high: three, low: three.map((v) => (v == null ? null : -v)) },
      }));
    } else if (data.spatial && (isAngle || column === 'z') && column !== 'yaw') {
      const values = isAngle ? unwoven(track[column]) : track[column];
      cards.push(charts.add({
        title: name, note: `±3σ shaded, ${unit}`, t: track.t, unit,
        series: [{ name: 'estimate', values, tint: 'estimate' }],
        band: {
          high: values.map((v, i) => (v == null ? null : v + three[i])),
          low: values.map((v, i) => (v == null ? null : v - three[i])),
        },
      }));
    }
  }
  if (!has('x')) {
    cards.push(charts.add({
      title: 'σ of the position', note: 'east blue, north green, m', t: track.t, unit: 'm',
      series: [{ name: 'east', values: track.sx, tint: 'estimate' }, { name: 'north', values: track.sy, tint: 'used' }],
      range: (u, low, high) => [0, (high || 1) * 1.08],
    }));
  }
  if (!has('yaw') || !reference.has_yaw) {
    cards.push(charts.add({
      title: 'σ of the heading', note: '°', t: track.t, unit: '°', series: [{ name: 'σ', values: track.syaw, tint: 'estimate' }],
      range: (u, low, high) => [0, (high || 1) * 1.08],
    }));
  }
  return cards;
}

/** Where a χ² variable with n degrees of freedom, divided by n, lies in 95 % (Wilson and Hilferty, 1931). */
function chiSquaredBand(n) {
  const at = (z) => Math.max(1 - 2 / (9 * n) + z * Math.sqrt(2 / (9 * n)), 0.02) ** 3;
  return [at(-1.96), at(1.96)];
}

/** NIS over its expectation, in some hundred intervals, for each sensor that has updates. */
function addNisCharts(charts, data) {
  const { t, sensors } = data.sensor_series;
  const cards = [];
  sensors.forEach((sensor, k) => {
    if (!sensor.dof.length || !(sensor.dof.at(-1) > 0)) return;
    const times = [];
    const ratios = [];
    const low = [];
    const high = [];
    const shortest = (t.at(-1) - t[0]) / 110;
    let from = 0;
    for (let i = 1; i < t.length; ++i) {
      const dof = sensor.dof[i] - sensor.dof[from];
      if (i + 1 < t.length && (t[i] - t[from] < shortest || dof <= 0)) continue;
      if (dof > 0) {
        const [a, b] = chiSquaredBand(dof);
        times.push(0.5 * (t[from] + t[i]));
        ratios.push(Math.max((sensor.nis[i] - sensor.nis[from]) / dof, 1e-3));
        low.push(a);
        high.push(b);
      }
      from = i;
    }
    if (times.length < 2) return;
    const most = Math.max(...ratios, 3);
    const least = Math.min(...ratios, 0.3);
    cards.push(charts.add({
      title: data.sensors[k].name, note: '95 % band shaded', t: times, logarithmic: true,
      series: [{ name: 'NIS', values: ratios, tint: 'estimate', dots: true },
        { name: '', values: times.map(() => 1), tint: 'faint', width: 1, dash: [4, 4] }],
      band: { high, low }, range: () => [least / 1.3, most * 1.3],
    }));
  });
  return cards;
}

/** Biases, scales, offsets: the sensors' own states. */
function addStateCharts(charts, data) {
  // What no measurement ever changed shows nothing.
  const moving = data.states.filter(({ value }) => value.some((v) => v !== value[0]));
  return moving.map((state) => {
    const [name, unit] = nameAndUnit(state.name);
    return charts.add({
      title: `${state.sensor}: ${name}`, note: `±3σ shaded${unit ? ', ' + unit : ''}`, t: data.track.t, unit,
      series: [{ name: 'estimate', values: state.value, tint: 'estimate' }],
      band: {
        high: state.value.map((v, i) => (v == null ? null : v + 3 * state.sigma[i])),
        low: state.value.map((v, i) => (v == null ? null : v - 3 * state.sigma[i])),
      },
    });
  });
}

/** How many of the particles count. */
function addParticleCharts(charts, data) {
  const count = data.map?.particles.length ?? 0;
  if (count < 2) return [];
  return [charts.add({
    title: 'Effective sample size', note: `of ${count} particles`, t: data.track.t,
    series: [{ name: 'N_eff', values: data.track.n_eff, tint: 'estimate', width: 0.7 }],
    range: () => [0, count * 1.05],
  })];
}
