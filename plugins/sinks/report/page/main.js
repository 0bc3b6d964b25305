// Puts the page together.

(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  document.title = `${data.name || 'Run'}: report`;
  const page = document.getElementById('report');

  const map = new RunMap(data, (time) => showTime(time, 'map'));
  const legend = new Legend(map, data);
  const charts = new Charts(data, (time) => showTime(time, 'charts'), (window) => {
    map.showWindow(window);
    for (const button of document.querySelectorAll('.section button')) button.hidden = window == null;
  });
  const health = new HealthPanel(data, (window) => {
    charts.show(window);
  });

  function showTime(time, from) {
    map.showTime(time);
    legend.showTime(time);
    health.showTime(time);
    if (from !== 'charts') charts.showTime(time);
  }

  /** The time of an event, with some of what is around it. */
  function visit(time) {
    const half = 0.04 * charts.end;
    charts.show([Math.max(0, time - half), Math.min(charts.end, time + half)]);
    showTime(time, 'event');
    map.element.scrollIntoView({ block: 'center', behavior: 'smooth' });
  }

  function section(title, note, cards) {
    if (cards.length === 0) return [];
    const all = el('button', { hidden: true, onclick: () => charts.show(null) }, 'Show all times');
    return [el('div', { class: 'section' }, el('h2', {}, title), el('span', {}, note), all), el('div', { class: 'charts' }, ...cards)];
  }

  const hasReference = data.reference?.at_track.x.some((x) => x != null);
  const parts = [headline(data), tiles(data), findingsPanel(data, visit), el('section', { class: 'card map-card' }, map.element, legend.element),
    health.element];
  if (data.started) {
    const shaded = data.outages.length ? '; orange: outages' : '';
    parts.push(
      ...section(hasReference ? 'Error and σ' : 'Uncertainty', 'drag over a chart to enlarge a time, double-click to go back' + shaded, addPoseCharts(charts, data)),
      ...section('Consistency', 'normalised innovations squared (NIS) over their expectation: 1 if the filter is consistent, above if it is overconfident',
        [...addNisCharts(charts, data), ...addParticleCharts(charts, data)]),
      ...section('Biases and scales', 'the sensors\u2019 own states', addStateCharts(charts, data)));
  }
  parts.push(el('div', { class: 'section' }, el('h2', {}, 'Sensors and events')), sensorTable(data), eventsPanel(data, visit), configPanel(data));
  page.append(...parts.filter(Boolean));
  charts.drawAll();

  let width = page.clientWidth;
  new ResizeObserver(() => {
    if (page.clientWidth === width) return;
    width = page.clientWidth;
    charts.resize();
  }).observe(page);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    charts.drawAll();
    map.draw();
  });
})();
