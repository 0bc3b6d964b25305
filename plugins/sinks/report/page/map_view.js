// The view of the map: what it shows, how the pointer moves it, its grid and its scale.

/** All that counts for the view; of the fixes all but the outermost hundredth. */
function extentOf(data) {
  const box = { left: Infinity, right: -Infinity, low: Infinity, high: -Infinity };
  const add = (x, y) => {
    if (x == null || y == null) return;
    box.left = Math.min(box.left, x);
    box.right = Math.max(box.right, x);
    box.low = Math.min(box.low, y);
    box.high = Math.max(box.high, y);
  };
  const most = (values) => {
    const sorted = values.filter((v) => v != null).sort((a, b) => a - b);
    const cut = Math.floor(sorted.length / 100);
    return [sorted[cut], sorted[sorted.length - 1 - cut]];
  };
  data.track.x.forEach((x, i) => add(x, data.track.y[i]));
  data.reference?.line.x.forEach((x, i) => add(x, data.reference.line.y[i]));
  data.reference?.landmarks.forEach(([, x, y]) => add(x, y));
  for (const map of data.map?.maps ?? []) {
    map.landmarks.forEach((l) => add(l.x, l.y));
    if (!map.grid) continue;
    const { x, y, yaw, width_m: w, height_m: h } = map.grid;
    for (const [u, v] of [[0, 0], [w, 0], [0, h], [w, h]])
      add(x + u * Math.cos(yaw) - v * Math.sin(yaw), y + u * Math.sin(yaw) + v * Math.cos(yaw));
  }
  for (const fixes of data.fixes) {
    if (fixes.x.length === 0) continue;
    const [left, right] = most(fixes.x);
    const [low, high] = most(fixes.y);
    add(left, low);
    add(right, high);
  }
  return box.left <= box.right ? box : { left: -10, right: 10, low: -10, high: 10 };
}

/** The pointer and the wheel move the view of a `RunMap`. */
function listenTo(run) {
  const { canvas } = run;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const fingers = new Map();
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, place(event));
    canvas.classList.add('dragged');
  });
  canvas.addEventListener('pointermove', (event) => {
    const now = place(event);
    const before = fingers.get(event.pointerId);
    if (!before) return run.point(now);
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
      const apart = (p) => Math.hypot(p.x - other.x, p.y - other.y);
      if (apart(before) > 0) run.zoom(apart(now) / apart(before), other);
    } else {
      run.view.x -= (now.x - before.x) / run.view.scale;
      run.view.y += (now.y - before.y) / run.view.scale;
      run.isFitted = false;
      run.draw();
    }
    fingers.set(event.pointerId, now);
  });
  const release = (event) => {
    fingers.delete(event.pointerId);
    if (fingers.size === 0) canvas.classList.remove('dragged');
  };
  canvas.addEventListener('pointerup', release);
  canvas.addEventListener('pointercancel', release);
  canvas.addEventListener('pointerleave', () => run.onTime(null));
  canvas.addEventListener('dblclick', (event) => run.zoom(2, place(event)));
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    run.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0016)), place(event));
  }, { passive: false });
}

function drawGrid(run, c) {
  const step = roundStep(95 / run.view.scale);
  const low = run.toMap({ x: 0, y: run.height });
  const high = run.toMap({ x: run.width, y: 0 });
  c.strokeStyle = color('grid');
  c.fillStyle = color('faint');
  c.lineWidth = 1;
  c.font = '11px ' + color('sans');
  const label = (value) => Number(value.toPrecision(10)).toString().replace('-', '−');
  const line = (x1, y1, x2, y2) => {
    c.beginPath();
    c.moveTo(x1, y1);
    c.lineTo(x2, y2);
    c.stroke();
  };
  c.textAlign = 'center';
  for (let k = Math.ceil(low.x / step); k * step <= high.x; ++k) {
    const [u] = run.toPixel(k * step, 0);
    line(u, 0, u, run.height);
    if (u > 60 && u < run.width - 150) c.fillText(label(k * step), u, run.height - 6);
  }
  c.textAlign = 'left';
  for (let k = Math.ceil(low.y / step); k * step <= high.y; ++k) {
    const [, v] = run.toPixel(0, k * step);
    line(0, v, run.width, v);
    if (v > 125 && v < run.height - 22) c.fillText(label(k * step), 6, v - 4);
  }
  c.fillText('m', 6, run.height - 6);
}

function drawScale(run) {
  const metres = roundStep(70 / run.view.scale);
  run.scale.textContent = metres >= 1000 ? `${metres / 1000} km` : metres >= 1 ? `${metres} m`
    : metres >= 0.01 ? `${Math.round(metres * 100)} cm` : `${metres * 1000} mm`;
  run.scale.style.width = `${metres * run.view.scale + 12}px`;
}
