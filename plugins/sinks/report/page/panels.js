// Everything but map and charts: key figures, health, tables, configuration.

/** Title, date and length of the log. */
function headline(data) {
  const facts = [data.date, `${data.duration} of log`];
  const particles = data.map?.particles.length ?? 0;
  if (particles > 1) facts.push(`${particles} particles`);
  const element = el('header', {}, el('h1', {}, data.name || 'Run'), el('span', { class: 'facts' }, facts.filter(Boolean).join(' · ')));
  if (data.interrupted) element.append(el('span', { class: 'facts' }, el('b', {}, 'interrupted')));
  return element;
}

/** The sum of the ways between the points of the track. Noise in place is left out: steps under 5 cm do not count. Steps of
 * corrections do, so with fixes of a metre it is longer than the way that was driven. */
function distance(track) {
  let sum = 0;
  let last = 0;
  for (let i = 1; i < track.x.length; ++i) {
    const step = Math.hypot(track.x[i] - track.x[last], track.y[i] - track.y[last], track.z ? track.z[i] - track.z[last] : 0);
    if (step < 0.05 && i + 1 < track.x.length) continue;
    sum += step;
    last = i;
  }
  return sum;
}

function tiles(data) {
  const { track, reference } = data;
  const element = el('div', { class: 'tiles' });
  const tile = (name, [value, unit], more) => element.append(el('div', { class: 'tile' }, el('div', { class: 'name' }, name),
    el('div', { class: 'value' }, value, unit ? el('small', {}, ' ' + unit) : null), el('div', { class: 'more' }, more ?? '\u00a0')));
  if (!data.started) {
    tile('Estimate', ['none', ''], 'the filter did not start');
    return element;
  }
  const last = track.t.length - 1;
  const way = distance(track);
  if (way > 0.05) tile('Distance', length(way), `of the online estimate, in ${data.duration}`);
  const at = reference?.at_track;
  const error = at ? statistics(track.x.map((x, i) => (at.x[i] == null ? null : Math.hypot(x - at.x[i], track.y[i] - at.y[i])))) : null;
  if (error?.count) {
    tile(data.spatial ? 'Error in the plane' : 'Position error', length(error.rms), `RMS; max ${length(error.max).join(' ')}`);
    if (reference.has_yaw) {
      const yaw = statistics(minus(track.yaw, at.yaw, wrapped));
      tile('Heading error', [digits(yaw.rms), '°'], `RMS; max ${digits(yaw.max)}°`);
    }
  }
  const sigma = (i) => Math.sqrt(Math.max(track.sx[i] ** 2, track.sy[i] ** 2));
  let largest = 0;
  for (let i = 0; i <= last; ++i) largest = Math.max(largest, sigma(i));
  tile('σ of the position', length(sigma(last)), `at the end; max ${length(largest).join(' ')}`);
  const landmarks = (data.map?.maps ?? []).flatMap((map) => map.landmarks).filter((l) => l.confirmed);
  if (landmarks.length) tile('Landmarks', [whole(landmarks.length), ''], 'confirmed');
  const grid = data.map?.maps.find((map) => map.grid)?.grid;
  if (grid) tile('Map', [`${digits(grid.width_m)} × ${digits(grid.height_m)}`, 'm'], `cells of ${length(grid.resolution_m).join(' ')}`);
  const shares = healthRows(data)[0].shares;
  const ok = shares.ok ?? 0;
  tile('Health', [digits(100 * ok), '%'], shares.lost ? `of the time ok; lost ${digits(100 * shares.lost, 2)} %` : 'of the time ok');
  return element;
}

/** Rows of segments [{from, to, state, reason}]: of the pose, and of every sensor. */
function healthRows(data) {
  const end = Math.max(data.duration_s ?? 0, data.track.t.at(-1) ?? 0);
  const rows = [{ name: 'pose', segments: [] }, ...data.sensors.map((sensor) => ({ name: sensor.name, segments: [] }))];
  for (const [t, sensor, state, reason] of data.health.changes) {
    const { segments } = rows[sensor == null ? 0 : sensor + 1] ?? rows[0];
    if (segments.length) segments.at(-1).to = t;
    segments.push({ from: t, to: end, state, reason });
  }
  for (const row of rows) {
    row.shares = {};
    const all = row.segments.reduce((sum, s) => sum + s.to - s.from, 0) || 1;
    for (const s of row.segments) row.shares[s.state] = (row.shares[s.state] ?? 0) + (s.to - s.from) / all;
  }
  return rows;
}

class HealthPanel {
  constructor(data, onWindow) {
    this.end = Math.max(data.duration_s ?? 0, data.track.t.at(-1) ?? 0) || 1;
    const rows = healthRows(data);
    const grid = el('div', { class: 'health' });
    this.cursors = [];
    const states = new Set();
    rows.forEach((row, i) => {
      const bar = el('div', { class: i ? 'bar' : 'bar all' });
      for (const s of row.segments) {
        states.add(s.state);
        const share = (t) => `${100 * t / this.end}%`;
        bar.append(el('button', {
          class: s.state, style: `left:${share(s.from)};width:${share(s.to - s.from)}`, tabindex: s.state === 'ok' ? '-1' : null,
          title: `${row.name}: ${s.state}, ${clock(s.from)} to ${clock(s.to)}${s.reason ? '\n' + s.reason : ''}`,
          'aria-label': `${row.name} ${s.state} from ${clock(s.from)} to ${clock(s.to)}`,
          onclick: () => onWindow(this.around(s)),
        }));
      }
      const cursor = el('div', { class: 'cursor', hidden: true });
      this.cursors.push(cursor);
      bar.append(cursor);
      const share = 100 * (row.shares.ok ?? 0);
      grid.append(el('div', { class: i ? 'who' : 'who all' }, row.name), bar,
        el('div', { class: 'share' }, row.segments.length ? `${share > 99.95 ? '100' : share.toFixed(1)} % ok` : '–'));
    });
    const meanings = { ok: 'ok', degraded: 'degraded', faulty: 'faulty', lost: 'lost', silent: 'no measurements' };
    const keys = el('div', { class: 'keys' });
    for (const [state, meaning] of Object.entries(meanings))
      if (states.has(state)) keys.append(el('span', {}, el('i', { class: state }), meaning));
    if (data.health.left_out) keys.append(el('span', {}, `${whole(data.health.left_out)} later changes are left out`));
    this.element = el('section', { class: 'card' },
      el('h2', {}, 'Health', el('small', {}, 'a click shows that time in the charts; the reason is in the tooltip')), grid, keys);
  }

  around({ from, to }) {
    const margin = Math.max(0.15 * (to - from), 0.005 * this.end);
    return [Math.max(0, from - margin), Math.min(this.end, to + margin)];
  }

  showTime(time) {
    for (const cursor of this.cursors) {
      cursor.hidden = time == null;
      if (time != null) cursor.style.left = `${100 * time / this.end}%`;
    }
  }
}

function sensorTable(data) {
  const head = ['Sensor', 'Rate', 'Measured', 'Used', 'Rejected', 'NIS / expected', 'Verdict'];
  const table = el('table', { class: 'rows', id: 'sensors' },
    el('thead', {}, el('tr', {}, ...head.map((name, i) => el('th', { class: i > 0 && i < 6 ? 'number' : null }, name)))));
  const body = el('tbody');
  for (const s of data.sensors) {
    const tone = s.verdict.startsWith('consistent') ? 'good' : s.verdict.startsWith('over') ? 'bad' : s.verdict.startsWith('conservative') ? 'warn' : '';
    const others = Object.entries(s.others).map(([why, count]) => `${whole(count)} ${why}`).join(', ');
    const percent = s.measurements ? ` (${digits(100 * s.rejected / s.measurements, 2)} %)` : '';
    body.append(el('tr', {},
      el('td', {}, el('b', {}, s.name), ' ', el('small', {}, s.plugin || 'maps only')),
      el('td', { class: 'number' }, digits(s.rate_hz) + ' Hz'),
      el('td', { class: 'number' }, whole(s.measurements)),
      el('td', { class: 'number' }, whole(s.used)),
      el('td', { class: 'number' }, whole(s.rejected), s.rejected ? el('small', {}, percent) : null),
      el('td', { class: 'number' }, s.nis == null ? '–' : digits(s.nis),
        s.nis == null ? null : el('small', {}, ` (${digits(s.nis_low)} to ${digits(s.nis_high)})`)),
      el('td', {}, el('span', { class: 'verdict ' + tone }, s.verdict), others ? el('div', {}, el('small', {}, others)) : null)));
  }
  table.append(body);
  return el('section', { class: 'card' },
    el('h2', {}, 'Sensors', el('small', {}, 'in brackets: where 95 % of the runs of a consistent filter lie')), el('div', { class: 'scroll' }, table));
}

/** What the diagnosis found: which sensor, what is wrong, what to change. Absent if there is nothing. */
function findingsPanel(data, onTime) {
  if (!data.findings.length) return null;
  const list = data.findings.map((finding) => {
    const who = finding.certainty === 'one of' ? `one of ${finding.sensors.join(', ')}: ` : finding.sensors.length ? `${finding.sensors[0]}: ` : '';
    return el('div', { class: 'finding' }, el('div', {},
      el('p', {}, el('b', {}, who), finding.text, ' ', timeButton(finding.t, onTime)),
      finding.suggestion ? el('p', {}, 'Try ', el('code', {}, finding.suggestion)) : null));
  });
  return el('section', { class: 'card', id: 'findings' }, el('h2', {}, 'Findings'), ...list);
}

const timeButton = (t, onTime) => el('button', { class: 'event-time', title: 'Show in the charts', onclick: () => onTime(t) }, clock(t));

function eventsPanel(data, onTime) {
  const rows = data.events.first.map((event) => el('tr', {},
    el('td', { class: 'number time' }, timeButton(event.t, onTime)), el('td', { class: event.failure ? 'failure' : null }, event.text)));
  const line = (text) => rows.push(el('tr', {}, el('td', {}), el('td', {}, text)));
  if (data.events.count > data.events.first.length) line(`… and ${whole(data.events.count - data.events.first.length)} more`);
  data.notices.forEach((notice) => line(notice));
  data.bad_records.first.forEach(([place, reason]) => line(`skipped ${place}: ${reason}`));
  if (data.bad_records.count > data.bad_records.first.length)
    line(`… and ${whole(data.bad_records.count - data.bad_records.first.length)} more skipped records`);
  return el('section', { class: 'card' }, el('h2', {}, 'Events'),
    rows.length ? el('div', { class: 'scroll' }, el('table', { class: 'rows', id: 'events' }, el('tbody', {}, ...rows)))
      : el('div', { class: 'nothing' }, 'None.'));
}

function configPanel(data) {
  if (!data.config) return null;
  const pre = el('pre');
  // What was filled in is less important than what was given.
  for (const line of data.config.split('\n')) {
    const isDefault = /# default\s*$/.test(line);
    pre.append(isDefault ? el('span', { class: 'default' }, line + '\n') : line + '\n');
  }
  return el('details', { class: 'card', id: 'config' }, el('summary', {}, 'Configuration'), pre);
}

/** A sample of how something is drawn on the map. */
function sample([kind, tint]) {
  const shapes = {
    line: '<path d="M1 8H27" stroke-width="2.4"/>',
    thin: '<path d="M1 8H27" stroke-width="1"/>',
    thick: '<path d="M3 8H25" stroke-width="8" opacity=".6"/>',
    dot: '<circle cx="14" cy="8" r="3.4" fill="COLOR" stroke="none"/>',
    ring: '<ellipse cx="14" cy="8" rx="9" ry="5.5" stroke-width="1.2" fill="COLOR" fill-opacity=".15"/>',
    cross: '<path d="M10 4l8 8M18 4l-8 8" stroke-width="1.6"/>',
    box: '<rect x="8" y="2" width="12" height="12" fill="COLOR" stroke="none"/>',
    ends: '<circle cx="6" cy="8" r="4" stroke-width="2.4"/><path d="M28 8l-11 5 3-5-3-5z" fill="COLOR" stroke="none"/>',
  };
  const holder = el('span', { style: 'display:flex' });
  holder.innerHTML = `<svg width="28" height="16" fill="none" stroke="COLOR">${shapes[kind]}</svg>`.replaceAll('COLOR', `var(--${tint})`);
  return holder;
}

class Legend {
  constructor(map, data) {
    this.data = data;
    const buttons = [...map.layers].reverse().map((layer) => el('button', {
      'aria-pressed': String(layer.visible), title: 'Show or hide',
      onclick: (event) => {
        layer.visible = !layer.visible;
        event.currentTarget.setAttribute('aria-pressed', layer.visible);
        map.draw();
      },
    }, sample(layer.mark), layer.name, layer.count == null ? null : el('span', { class: 'count' }, whole(layer.count))));
    this.readout = el('div', { class: 'readout' });
    this.element = el('div', { class: 'legend' }, ...buttons, this.note(), this.readout);
    this.showTime(null);
  }

  note() {
    const moved = this.data.reference?.alignment;
    if (!moved) return null;
    return el('div', { class: 'note' }, `The reference has a frame of its own and was moved onto the estimate: by ${digits(moved.x)} m, `
      + `${digits(moved.y)} m, and turned by ${digits(moved.yaw)}°.`);
  }

  /** The pose at a time; null: at the end. */
  showTime(time) {
    const { track } = this.data;
    if (track.t.length === 0) return;
    const i = time == null ? track.t.length - 1 : indexAt(track.t, time);
    const rows = [['east', withSigma(track.x[i], track.sx[i]), 'm'], ['north', withSigma(track.y[i], track.sy[i]), 'm']];
    if (track.z) rows.push(['up', withSigma(track.z[i], track.sz[i]), 'm']);
    rows.push(['heading', withSigma(track.yaw[i], track.syaw[i]), '°']);
    this.readout.replaceChildren(el('table', {},
      el('caption', {}, time == null ? 'Pose at the end (1σ)' : `Pose at ${clock(track.t[i], 2)} (1σ)`),
      ...rows.map(([name, value, unit]) => el('tr', {}, el('td', {}, name), el('td', {}, `${value} ${unit}`)))));
  }
}
