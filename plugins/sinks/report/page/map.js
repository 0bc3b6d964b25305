// The map: what the robot saw and where it was, with pan and zoom.

/** Half axes [m] and the direction of the longer one of a covariance in the plane. */
function ellipseOf(pxx, pxy, pyy, sigmas) {
  const middle = 0.5 * (pxx + pyy);
  const spread = Math.hypot(0.5 * (pxx - pyy), pxy);
  return {
    a: sigmas * Math.sqrt(Math.max(middle + spread, 0)),
    b: sigmas * Math.sqrt(Math.max(middle - spread, 0)),
    angle: 0.5 * Math.atan2(2 * pxy, pxx - pyy),
  };
}

class RunMap {
  /** `onTime(t or null)`: the pointer is near the path at that time. */
  constructor(data, onTime) {
    this.data = data;
    this.onTime = onTime;
    this.window = null; // the times that the charts show
    this.time = null;
    this.canvas = el('canvas', { role: 'img', 'aria-label': 'Map of the run' });
    this.scale = el('div', { class: 'scale' });
    this.element = el('div', { class: 'map' }, this.canvas,
      el('div', { class: 'buttons' },
        el('button', { title: 'Zoom in', 'aria-label': 'Zoom in', onclick: () => this.zoom(1.5) }, '+'),
        el('button', { title: 'Zoom out', 'aria-label': 'Zoom out', onclick: () => this.zoom(1 / 1.5) }, '−'),
        el('button', { title: 'Show all', 'aria-label': 'Show all', onclick: () => this.fit() }, 'all')),
      this.scale);
    this.layers = layersOf(this);
    listenTo(this);
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  // --- view ---

  fit() {
    const box = extentOf(this.data);
    const margin = 46;
    const wide = Math.max(box.right - box.left, 1);
    const tall = Math.max(box.high - box.low, 1);
    this.view = {
      x: 0.5 * (box.left + box.right),
      y: 0.5 * (box.low + box.high),
      scale: Math.min((this.width - 2 * margin) / wide, (this.height - 2 * margin) / tall),
    };
    this.isFitted = true;
    this.draw();
  }

  zoom(factor, at = { x: this.width / 2, y: this.height / 2 }) {
    const before = this.toMap(at);
    this.view.scale = Math.min(Math.max(this.view.scale * factor, 1e-4), 1e5);
    const after = this.toMap(at);
    this.view.x += before.x - after.x;
    this.view.y += before.y - after.y;
    this.isFitted = false;
    this.draw();
  }

  toPixel(x, y) {
    return [this.width / 2 + (x - this.view.x) * this.view.scale, this.height / 2 - (y - this.view.y) * this.view.scale];
  }
  toMap(p) {
    return { x: this.view.x + (p.x - this.width / 2) / this.view.scale, y: this.view.y - (p.y - this.height / 2) / this.view.scale };
  }

  resize() {
    const { clientWidth, clientHeight } = this.element;
    if (!clientWidth || !clientHeight) return;
    const ratio = window.devicePixelRatio || 1;
    this.width = clientWidth;
    this.height = clientHeight;
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    if (!this.view || this.isFitted) this.fit();
    else this.draw();
  }

  /** Reports the time at which the robot was at the pointer. */
  point(p) {
    const { x, y, t } = this.data.track;
    let nearest = 16 ** 2;
    let time = null;
    for (let i = 0; i < t.length; ++i) {
      if (this.window && (t[i] < this.window[0] || t[i] > this.window[1])) continue;
      const [u, v] = this.toPixel(x[i], y[i]);
      const distance = (u - p.x) ** 2 + (v - p.y) ** 2;
      if (distance < nearest) {
        nearest = distance;
        time = t[i];
      }
    }
    this.onTime(time);
  }

  showTime(time) {
    if (this.time === time) return;
    this.time = time;
    this.drawSoon();
  }
  showWindow(window) {
    this.window = window;
    this.drawSoon();
  }
  drawSoon() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.draw();
    });
  }

  // --- drawing, from the background to the foreground ---

  draw() {
    if (!this.view) return;
    const c = this.canvas.getContext('2d');
    const ratio = window.devicePixelRatio || 1;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = color('card');
    c.fillRect(0, 0, this.width, this.height);
    c.lineJoin = c.lineCap = 'round';
    const isGridMap = (layer) => layer.mark[0] === 'box';
    for (const layer of this.layers) if (layer.visible && isGridMap(layer)) layer.draw(c);
    drawGrid(this, c);
    for (const layer of this.layers) if (layer.visible && !isGridMap(layer)) layer.draw(c);
    this.drawCursor(c);
    drawScale(this);
  }

  drawGridMap(c, grid) {
    if (!grid.image) {
      grid.image = new Image();
      grid.image.onload = () => {
        grid.isLoaded = true;
        this.drawSoon();
      };
      grid.image.src = 'data:image/png;base64,' + grid.png;
    }
    if (!grid.isLoaded) return;
    const [u, v] = this.toPixel(grid.x, grid.y);
    c.save();
    c.translate(u, v);
    c.rotate(-grid.yaw);
    c.imageSmoothingEnabled = this.view.scale * grid.resolution_m < 3;
    c.filter = matchMedia('(prefers-color-scheme: dark)').matches ? 'invert(.86)' : 'none';
    c.drawImage(grid.image, 0, -grid.height_m * this.view.scale, grid.width_m * this.view.scale, grid.height_m * this.view.scale);
    c.restore();
  }

  /** A line; what is null breaks it. Points nearer than half a pixel are left out. */
  trace(c, x, y, from = 0, to = x.length) {
    c.beginPath();
    let pen = false;
    let lastU = 0;
    let lastV = 0;
    for (let i = from; i < to; ++i) {
      if (x[i] == null || y[i] == null) {
        pen = false;
        continue;
      }
      const [u, v] = this.toPixel(x[i], y[i]);
      if (!pen) c.moveTo(u, v);
      else if (Math.abs(u - lastU) + Math.abs(v - lastV) < 0.5 && i + 1 < to) continue;
      else c.lineTo(u, v);
      pen = true;
      lastU = u;
      lastV = v;
    }
  }

  drawLine(c, x, y, tint, width) {
    this.trace(c, x, y);
    c.strokeStyle = color(tint);
    c.lineWidth = width;
    c.stroke();
  }

  range(from, to) {
    const { t } = this.data.track;
    return [indexAt(t, from), Math.min(indexAt(t, to) + 2, t.length)];
  }

  drawEstimate(c) {
    const { x, y } = this.data.track;
    c.strokeStyle = color('estimate');
    c.lineWidth = 2;
    if (this.window) {
      c.globalAlpha = 0.22;
      this.trace(c, x, y);
      c.stroke();
      c.globalAlpha = 1;
      c.lineWidth = 2.6;
    }
    const [from, to] = this.window ? this.range(...this.window) : [0, x.length];
    this.trace(c, x, y, from, to);
    c.stroke();
  }

  drawOutages(c) {
    const { x, y } = this.data.track;
    c.strokeStyle = color('outage-line');
    c.globalAlpha = 0.55;
    c.lineWidth = 9;
    for (const outage of this.data.outages) {
      const [from, to] = this.range(outage.from, outage.to);
      this.trace(c, x, y, from, to);
      c.stroke();
    }
    c.globalAlpha = 1;
  }

  drawEllipse(c, x, y, shape) {
    const [u, v] = this.toPixel(x, y);
    c.beginPath();
    c.ellipse(u, v, shape.a * this.view.scale, shape.b * this.view.scale, -shape.angle, 0, 2 * Math.PI);
  }

  /** Only so many that they do not hide each other, and none that is smaller than the line. */
  drawEllipses(c) {
    const { x, y, sx, sy, sxy } = this.data.track;
    const [from, to] = this.window ? this.range(...this.window) : [0, x.length];
    c.strokeStyle = color('estimate');
    c.fillStyle = color('band');
    c.lineWidth = 1;
    const drawn = [];
    for (let i = from; i < to; ++i) {
      const [u, v] = this.toPixel(x[i], y[i]);
      if (u < -50 || v < -50 || u > this.width + 50 || v > this.height + 50) continue;
      const shape = ellipseOf(sx[i] ** 2, sxy[i], sy[i] ** 2, 3);
      const size = shape.a * this.view.scale;
      if (!(size >= 3) || size > 2000) continue;
      const isFree = (other) => Math.hypot(u - other.u, v - other.v) > Math.max(1.15 * (size + other.size), 34);
      if (!drawn.every(isFree)) continue;
      drawn.push({ u, v, size });
      this.drawEllipse(c, x[i], y[i], shape);
      c.fill();
      c.globalAlpha = 0.75;
      c.stroke();
      c.globalAlpha = 1;
      if (drawn.length >= 150) break;
    }
  }

  drawDots(c, x, y, tint, radius) {
    c.fillStyle = color(tint);
    c.globalAlpha = 0.75;
    for (let i = 0; i < x.length; ++i) {
      const [u, v] = this.toPixel(x[i], y[i]);
      if (u < -5 || v < -5 || u > this.width + 5 || v > this.height + 5) continue;
      c.beginPath();
      c.arc(u, v, radius, 0, 2 * Math.PI);
      c.fill();
    }
    c.globalAlpha = 1;
  }

  drawSurvey(c) {
    c.strokeStyle = color('reference');
    c.lineWidth = 1.4;
    for (const [, x, y] of this.data.reference.landmarks) {
      const [u, v] = this.toPixel(x, y);
      c.beginPath();
      c.moveTo(u - 5, v - 5);
      c.lineTo(u + 5, v + 5);
      c.moveTo(u + 5, v - 5);
      c.lineTo(u - 5, v + 5);
      c.stroke();
    }
  }

  drawLandmarks(c, landmarks) {
    const size = landmarks.length > 150 ? 2 : 2.8;
    for (const l of landmarks) {
      const shape = ellipseOf(l.P[0], l.P[1], l.P[2], 3);
      if (shape.a * this.view.scale > size + 1.5) {
        this.drawEllipse(c, l.x, l.y, shape);
        c.strokeStyle = color('landmark');
        c.globalAlpha = 0.5;
        c.lineWidth = 1;
        c.stroke();
        c.globalAlpha = 1;
      }
      const [u, v] = this.toPixel(l.x, l.y);
      c.beginPath();
      c.arc(u, v, Math.max(size, (l.r ?? 0) * this.view.scale), 0, 2 * Math.PI);
      c.fillStyle = color('landmark');
      c.fill();
    }
    if (landmarks.length > 60 && this.isFitted) return;
    c.fillStyle = color('ink');
    c.font = '10.5px ' + color('sans');
    for (const l of landmarks) {
      const [u, v] = this.toPixel(l.x, l.y);
      if (u < 0 || v < 0 || u > this.width || v > this.height) continue;
      const away = Math.max(size, (l.r ?? 0) * this.view.scale) + 3;
      c.fillText(String(l.id), u + away, v - away + 3);
    }
  }

  drawProvisional(c, landmarks) {
    c.strokeStyle = color('provisional');
    c.lineWidth = 1;
    for (const l of landmarks) {
      const [u, v] = this.toPixel(l.x, l.y);
      c.beginPath();
      c.arc(u, v, 3, 0, 2 * Math.PI);
      c.stroke();
    }
  }

  drawParticles(c) {
    this.drawDots(c, this.data.map.particles.map((p) => p[0]), this.data.map.particles.map((p) => p[1]), 'particle', 1.8);
    if (this.data.map.modes?.length > 1) this.drawModes(c, this.data.map.modes);
  }

  /** Several places at which the particles have the robot: a ring at each, with its share of their weight. */
  drawModes(c, modes) {
    c.strokeStyle = c.fillStyle = color('particle');
    c.lineWidth = 1.5;
    for (const [x, y, weight] of modes) {
      const [u, v] = this.toPixel(x, y);
      c.beginPath();
      c.arc(u, v, 8, 0, 2 * Math.PI);
      c.stroke();
      c.fillText(`${Math.round(100 * weight)} %`, u + 11, v - 6);
    }
  }

  drawRobot(c, i, tint) {
    const { x, y, yaw } = this.data.track;
    const [u, v] = this.toPixel(x[i], y[i]);
    c.save();
    c.translate(u, v);
    c.rotate(-yaw[i] * Math.PI / 180);
    c.beginPath();
    c.moveTo(12, 0);
    c.lineTo(-8, 7.5);
    c.lineTo(-3.5, 0);
    c.lineTo(-8, -7.5);
    c.closePath();
    c.lineWidth = 2.5;
    c.strokeStyle = color('card');
    c.stroke();
    c.fillStyle = color(tint);
    c.fill();
    c.restore();
  }

  drawEnds(c) {
    const { x, y } = this.data.track;
    const last = x.length - 1;
    const [u, v] = this.toPixel(x[0], y[0]);
    c.beginPath();
    c.arc(u, v, 6, 0, 2 * Math.PI);
    c.fillStyle = color('card');
    c.fill();
    c.lineWidth = 3;
    c.strokeStyle = color('ink');
    c.stroke();
    this.drawRobot(c, last, 'ink');
    c.font = '600 12px ' + color('sans');
    const word = (text, a, b) => {
      c.lineWidth = 3.5;
      c.strokeStyle = color('card');
      c.strokeText(text, a, b);
      c.fillStyle = color('ink');
      c.fillText(text, a, b);
    };
    const [p, q] = this.toPixel(x[last], y[last]);
    const isNear = Math.hypot(p - u, q - v) < 40;
    word('start', u + 11, v - 8);
    word('end', p + 13, isNear ? Math.max(q, v) + 18 : q - 9);
  }

  drawCursor(c) {
    const { t, x, y, sx, sy, sxy } = this.data.track;
    if (this.time == null || t.length === 0) return;
    const i = indexAt(t, this.time);
    this.drawEllipse(c, x[i], y[i], ellipseOf(sx[i] ** 2, sxy[i], sy[i] ** 2, 3));
    c.strokeStyle = color('estimate');
    c.lineWidth = 1.5;
    c.stroke();
    this.drawRobot(c, i, 'estimate');
  }
}
