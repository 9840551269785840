'use strict';
// Graphs: curves over time or over each other, zoomed by dragging, with the values under the pointer.

const CURVES = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#56b4e9', '#e69f00'];

/** Round numbers between `low` and `high`, at most about `count`. */
function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1), power = 10 ** Math.floor(Math.log10(rough));
  if (!(rough > 0) || !Number.isFinite(power)) return [];
  const step = power * ([1, 2, 5, 10].find(n => n * power >= rough) ?? 10);
  const found = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n++) found.push(n * step);
  return found;
}

/** Least and greatest of finite values, with some air. */
function span(values, air = 0.05) {
  let low = Infinity, high = -Infinity;
  for (const v of values) {
    if (v < low) low = v;
    if (v > high) high = v;
  }
  if (!(low <= high)) return [0, 1];
  const size = high - low || Math.abs(high) || 1;
  return [low - air * size, high + air * size];
}

/** Charts that show the same range of x. */
class Group {
  constructor() { this.charts = []; this.range = null; this.at = null; }
  zoom(range) { this.range = range; this.charts.forEach(chart => chart.draw()); }
  point(at) { this.at = at; this.charts.forEach(chart => chart.draw()); }
}

/**
 * One graph. `x` and `y` are arrays of numbers; where `path` is set, x does not grow and y is not a function of it.
 * `lines` are values of y that are drawn dashed.
 */
class Chart {
  constructor(into, {name, x, y, labels, about = '', lines = [], path = false, group = new Group(), ink = CURVES[0]}) {
    Object.assign(this, {x, y, labels, lines, path, group, ink, about, drag: null});
    this.canvas = element('canvas', {tabindex: 0, role: 'img', 'aria-label': `${name}: ${about}`});
    this.readout = element('figcaption', {}, about);
    this.figure = element('figure', {class: path ? 'chart path' : 'chart'}, this.canvas, this.readout);
    into.append(this.figure);
    group.charts.push(this);
    this.listen();
    pictures.push(this);
    new ResizeObserver(() => this.resize()).observe(this.figure);
  }

  resize() {
    const ratio = Math.min(devicePixelRatio || 1, 3);
    this.width = this.figure.clientWidth;
    this.height = this.path ? Math.min(this.width, 320) : 170;
    this.canvas.width = Math.round(ratio * this.width);
    this.canvas.height = Math.round(ratio * this.height);
    this.canvas.style.height = `${this.height}px`;
    this.ratio = ratio;
    this.draw();
  }

  /** Ranges of x and y that are shown. */
  ranges() {
    const all = this.path ? span(this.x) : [this.x[0], this.x[this.x.length - 1]];
    const x = this.group.range ?? all;
    const inside = this.path && !this.group.range
      ? this.y : this.y.filter((_, n) => this.x[n] >= x[0] && this.x[n] <= x[1]);
    return {x, y: span(inside.length ? inside : this.y), all};
  }

  draw() {
    if (!this.width) return;
    const context = this.canvas.getContext('2d'), {x, y} = this.ranges();
    const left = 62, right = 10, top = 18, bottom = 34;
    const w = this.width - left - right, h = this.height - top - bottom;
    this.place = {left, w, x};
    const px = v => left + w * (v - x[0]) / (x[1] - x[0]), py = v => top + h * (1 - (v - y[0]) / (y[1] - y[0]));
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.fillStyle = color('--paper');
    context.fillRect(0, 0, this.width, this.height);
    this.axes(context, {x, y, px, py, left, top, w, h});
    context.save();
    context.beginPath();
    context.rect(left, top, w, h);
    context.clip();
    context.setLineDash([5, 4]);
    context.strokeStyle = color('--faint');
    for (const line of this.lines) this.stroke(context, [[left, py(line)], [left + w, py(line)]]);
    context.setLineDash([]);
    context.strokeStyle = this.ink;
    context.lineWidth = 1.4;
    this.stroke(context, this.path ? this.all(px, py) : this.visible(px, py, x, w));
    this.mark(context, px, py, x);
    if (this.drag) {
      context.fillStyle = 'rgba(128,128,128,.25)';
      context.fillRect(this.drag.from, top, this.drag.to - this.drag.from, h);
    }
    context.restore();
  }

  axes(context, {x, y, px, py, left, top, w, h}) {
    context.lineWidth = 1;
    context.font = '12px system-ui, sans-serif';
    context.strokeStyle = color('--line');
    context.fillStyle = color('--ink');
    context.textAlign = 'center';
    for (const tick of ticks(...x, w / 60)) {
      this.stroke(context, [[px(tick), top], [px(tick), top + h]]);
      context.fillText(digits(tick, 6), px(tick), top + h + 14);
    }
    context.textAlign = 'right';
    for (const tick of ticks(...y, h / 22)) {
      this.stroke(context, [[left, py(tick)], [left + w, py(tick)]]);
      context.fillText(digits(tick, 6), left - 6, py(tick) + 4);
    }
    context.fillText(this.labels[0], left + w, top + h + 29);
    context.textAlign = 'left';
    context.fillText(this.labels[1], 4, 12);
    context.strokeRect(left, top, w, h);
  }

  stroke(context, points) {
    context.beginPath();
    let open = false;
    for (const [x, y] of points) {
      if (!Number.isFinite(y)) open = false;
      else if (open) context.lineTo(x, y);
      else { context.moveTo(x, y); open = true; }
    }
    context.stroke();
  }

  all(px, py) { return Array.from(this.x, (x, n) => [px(x), py(this.y[n])]); }

  /** The curve in the range `x`; least and greatest value of every column of pixels where there are many. */
  visible(px, py, x, w) {
    let from = this.x.findIndex(v => v >= x[0]), to = this.x.findLastIndex(v => v <= x[1]);
    if (from < 0 || to < 0) return [];
    from = Math.max(0, from - 1);
    to = Math.min(this.x.length - 1, to + 1);
    const each = (to - from) / (2 * w);
    const points = [];
    if (each < 2) {
      for (let n = from; n <= to; n++) points.push([px(this.x[n]), py(this.y[n])]);
      return points;
    }
    for (let start = from; start <= to; start += each) {
      let low = Math.floor(start), high = low;
      for (let n = low; n <= to && n < start + each; n++) {
        if (this.y[n] < this.y[low]) low = n;
        if (this.y[n] > this.y[high]) high = n;
      }
      for (const n of low < high ? [low, high] : [high, low]) points.push([px(this.x[n]), py(this.y[n])]);
    }
    return points;
  }

  /** The sample nearest to the pointer. */
  mark(context, px, py, x) {
    const n = this.path ? this.near : this.nearest(this.group.at);
    if (n == null || n < 0) {
      this.readout.textContent = this.about;
      return;
    }
    const at = [px(this.x[n]), py(this.y[n])];
    context.strokeStyle = color('--faint');
    if (!this.path) this.stroke(context, [[at[0], 0], [at[0], this.height]]);
    context.fillStyle = this.ink;
    context.beginPath();
    context.arc(...at, 3.5, 0, 7);
    context.fill();
    const [a, b] = this.labels.map(label => label.replace(/ \[.*/, ''));
    const [ua, ub] = this.labels.map(label => / \[(.*)\]/.exec(label)?.[1] ?? '');
    this.readout.textContent = `${a} = ${digits(this.x[n], 6)} ${ua}, ${b} = ${digits(this.y[n], 6)} ${ub}`;
  }

  nearest(x) {
    if (x == null) return null;
    let low = 0, high = this.x.length - 1;
    while (high - low > 1) {
      const middle = low + high >> 1;
      if (this.x[middle] < x) low = middle; else high = middle;
    }
    return x - this.x[low] < this.x[high] - x ? low : high;
  }

  /** x at a place of the canvas. */
  value(at) {
    const {left, w, x} = this.place;
    return x[0] + (x[1] - x[0]) * Math.min(1, Math.max(0, (at - left) / w));
  }

  listen() {
    const at = event => event.clientX - this.canvas.getBoundingClientRect().left;
    this.canvas.addEventListener('pointerdown', event => {
      if (event.button || this.path) return;
      if (event.pointerType !== 'touch') {
        this.canvas.setPointerCapture(event.pointerId);
        this.drag = {from: at(event), to: at(event)};
      }
      this.group.point(this.value(at(event)));
    });
    this.canvas.addEventListener('pointermove', event => {
      if (this.drag) this.drag.to = at(event);
      if (this.path) this.hover(event); else this.group.point(this.value(at(event)));
    });
    this.canvas.addEventListener('pointerup', () => {
      const drag = this.drag;
      this.drag = null;
      if (drag && Math.abs(drag.to - drag.from) > 5) {
        this.group.zoom([drag.from, drag.to].map(x => this.value(x)).sort((a, b) => a - b));
      }
    });
    this.canvas.addEventListener('pointerleave', () => { this.near = null; this.group.point(null); });
    this.canvas.addEventListener('dblclick', () => this.group.zoom(null));
    this.canvas.addEventListener('keydown', event => this.key(event));
  }

  hover(event) {
    const box = this.canvas.getBoundingClientRect(), {x, y} = this.ranges();
    const at = [event.clientX - box.left, event.clientY - box.top];
    const w = this.width - 72, h = this.height - 52;
    let best = Infinity;
    for (let n = 0; n < this.x.length; n++) {
      const dx = 62 + w * (this.x[n] - x[0]) / (x[1] - x[0]) - at[0];
      const dy = 18 + h * (1 - (this.y[n] - y[0]) / (y[1] - y[0])) - at[1];
      if (dx * dx + dy * dy < best) { best = dx * dx + dy * dy; this.near = n; }
    }
    this.draw();
  }

  key(event) {
    const {x, all} = this.ranges(), size = x[1] - x[0], middle = this.group.at ?? (x[0] + x[1]) / 2;
    const shown = {
      '+': [middle - size / 4, middle + size / 4], '=': [middle - size / 4, middle + size / 4],
      '-': [middle - size, middle + size], '0': null,
      'ArrowLeft': [x[0] - size / 4, x[1] - size / 4], 'ArrowRight': [x[0] + size / 4, x[1] + size / 4],
    }[event.key];
    if (shown === undefined || this.path) return;
    event.preventDefault();
    if (!shown) return this.group.zoom(null);
    const width = Math.min(shown[1] - shown[0], all[1] - all[0]);
    const from = Math.min(Math.max(shown[0], all[0]), all[1] - width);
    this.group.zoom(width < all[1] - all[0] ? [from, from + width] : null);
  }
}
