// What the map can show: one layer for each kind of thing, from the background to the foreground.

/** Layers of a `RunMap`: name, mark in the legend, how it is drawn, how many there are, whether it is visible at first. */
function layersOf(run) {
  const { data } = run;
  const layers = [];
  const add = (name, mark, draw, count = null, visible = true) => layers.push({ name, mark, draw, count, visible });
  for (const map of data.map?.maps ?? []) {
    if (map.grid) add(`map “${map.name}”`, ['box', 'occupied'], (c) => run.drawGridMap(c, map.grid));
  }
  const kinds = { used: ['fix, used', 'used'], rejected: ['fix, rejected', 'rejected'], 'held out': ['fix, held out', 'held'] };
  for (const fixes of [...data.fixes].reverse()) {
    if (fixes.x.length === 0) continue;
    const [name, tint] = kinds[fixes.kind];
    add('GNSS ' + name, ['dot', tint], (c) => run.drawDots(c, fixes.x, fixes.y, tint, fixes.x.length > 1000 ? 1.6 : 2.2), fixes.count);
  }
  const reference = data.reference;
  if (reference?.line.x.length > 1)
    add('reference', ['line', 'reference'], (c) => run.drawLine(c, reference.line.x, reference.line.y, 'reference', 1.8));
  if (data.track.x.length) {
    add('3σ ellipse', ['ring', 'estimate'], (c) => run.drawEllipses(c));
    if (data.outages.length) {
      add('outage of ' + [...new Set(data.outages.map((o) => o.sensor))].join(', '), ['thick', 'outage-line'],
        (c) => run.drawOutages(c), data.outages.length);
    }
    add('estimate', ['line', 'estimate'], (c) => run.drawEstimate(c));
  }
  if (data.map?.path.x.length > 1 && data.map.maps.length)
    add('path of the best particle', ['thin', 'path'], (c) => run.drawLine(c, data.map.path.x, data.map.path.y, 'path', 1), null, false);
  if (reference?.landmarks.length)
    add('surveyed landmark', ['cross', 'reference'], (c) => run.drawSurvey(c), reference.landmarks.length);
  const landmarks = (data.map?.maps ?? []).flatMap((map) => map.landmarks);
  const confirmed = landmarks.filter((l) => l.confirmed);
  const provisional = landmarks.filter((l) => !l.confirmed);
  if (provisional.length)
    add('provisional landmark', ['ring', 'provisional'], (c) => run.drawProvisional(c, provisional), provisional.length);
  if (confirmed.length) add('landmark', ['dot', 'landmark'], (c) => run.drawLandmarks(c, confirmed), confirmed.length);
  if (data.map?.particles.length > 1)
    add('particle at the end', ['dot', 'particle'], (c) => run.drawParticles(c), data.map.particles.length);
  if (data.track.x.length) add('start and end', ['ends', 'ink'], (c) => run.drawEnds(c));
  return layers;
}
