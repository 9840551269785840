'use strict';
// The player of the fields.

/** From blue to red, white between them. */
const DIVERGING = [
  [33, 102, 172], [103, 169, 207], [209, 229, 240], [247, 247, 247], [253, 219, 199], [239, 138, 98], [178, 24, 43],
];

/** A picture of a scene that moves. */
class Player {
  constructor(into, scene, layers, maps) {
    Object.assign(this, {scene, layers, into});
    this.maps = {...maps, 'blue-red': DIVERGING, grey: [[20, 20, 20], [240, 240, 240]]};
    this.choices = scene.quantities.flatMap((about, quantity) => Player.choices(about, quantity));
    Object.assign(this, {playing: false, speed: 20, mesh: false, times: 1, fixed: true});
    this.frame = scene.times.length - 1;
    this.choice = this.choices[0];
    this.map = null;
    this.known = new Map();
    this.pointer = null;
    this.deep = scene.dimension === 3;
    this.view = new View(scene.dimension);
    this.moves = layers.some(layer => layer.motion);
    buildControls(this);
    listenTo(this);
    this.setChoice(0);
    pictures.push(this);
    new ResizeObserver(() => this.resize()).observe(this.stage);
  }

  /** What can be shown of a quantity: the size of a vector and all components. */
  static choices({label, symbols, size, unit, factor, body, signed}, quantity) {
    const all = symbols.map((symbol, component) => ({quantity, component, symbol, signed}));
    if (size) all.unshift({quantity, component: null, symbol: size, signed: false});
    return all.map(one => ({...one, unit, factor, body, label: `${label} ${one.symbol}`}));
  }

  /** Least and greatest value of what is shown, at all moments or at this one; extremes in few points do not count. */
  limits() {
    const key = this.choices.indexOf(this.choice) + (this.fixed ? 0 : 1000 * (this.frame + 1));
    if (this.known.has(key)) return this.known.get(key);
    const found = [], {body} = this.choice;
    const frames = this.fixed ? this.scene.times.map((_, t) => t) : [this.frame];
    for (const layer of this.layers) {
      const every = Math.ceil(layer.count * frames.length / 2e5);
      for (const t of frames) {
        const values = layer.read(t, this.choice, layer.colors);
        for (let p = t % every; p < layer.count; p += every) {
          if (layer.within[body][p] && Number.isFinite(values[p])) found.push(values[p]);
        }
      }
    }
    const sorted = Float32Array.from(found).sort();
    const tail = this.choice.component === null ? 0 : Math.floor(sorted.length / 500);
    let [low, high] = sorted.length ? [sorted[tail], sorted[sorted.length - 1 - tail]] : [0, 1];
    if (this.choice.component === null) low = 0;
    if (!(high - low > 1e-6 * Math.max(Math.abs(low), Math.abs(high)))) [low, high] = [low - 0.5, high + 0.5];
    this.known.set(key, [low, high]);
    return [low, high];
  }

  setChoice(number) {
    this.choice = this.choices[number];
    this.lists.quantity.value = number;
    if (!this.map || !this.chosenMap) this.setMap(this.choice.component === null ? 'viridis' : 'plasma');
    this.request();
  }

  setMap(name) {
    this.map = name;
    this.lists.map.value = name;
    this.palette = palette(this.maps[name], this.deep ? 16 : 1);
    const stops = this.maps[name].map(c => `rgb(${c})`);
    this.bar.style.background = `linear-gradient(to right, ${stops})`;
    this.request();
  }

  setFrame(frame) {
    const n = this.scene.times.length;
    this.frame = (frame % n + n) % n;
    this.slider.value = this.frame;
    this.request();
  }

  play(on = !this.playing) {
    this.playing = on && this.scene.times.length > 1;
    this.buttons.play.textContent = this.playing ? '❚❚' : '▶';
    this.buttons.play.setAttribute('aria-label', this.playing ? 'pause' : 'play');
    if (!this.playing) return;
    let last = performance.now();
    const tick = now => {
      if (!this.playing) return;
      if (now - last >= 1000 / this.speed - 1) {
        last = now;
        this.setFrame(this.frame + 1);
      }
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** The box of all, or of the bodies and what is around them; `null` if those are not small. */
  box(bodies) {
    const boxes = this.layers.map(layer => layer.box(bodies)).filter(box => box[0][0] <= box[0][1]);
    if (!boxes.length) return null;
    const whole = boxes.reduce((a, b) => a.map(([low, high], d) => [Math.min(low, b[d][0]), Math.max(high, b[d][1])]));
    if (!bodies) return whole;
    const outer = this.box(false), length = Math.max(...whole.map(([low, high]) => high - low));
    if (2 * length >= 0.5 * (outer[0][1] - outer[0][0])) return null;
    return whole.map(([low, high], d) => {
      const size = Math.min(d ? Math.max(0.9 * length, 1.4 * (high - low)) : 2 * length, outer[d][1] - outer[d][0]);
      const from = Math.min(Math.max((low + high - size) / 2, outer[d][0]), outer[d][1] - size);
      return [from, from + size];
    });
  }

  fit(bodies = false) {
    const box = bodies && this.box(true) || this.box(false);
    while (box.length < 3) box.push([0, 0]);
    this.view.fit(box, this.canvas.width, this.canvas.height);
    this.request();
  }

  resize() {
    const ratio = Math.min(devicePixelRatio || 1, 2), width = this.stage.clientWidth;
    if (!width) return;
    this.layers.forEach(layer => layer.move(this.frame, this.times));
    const [x, y] = this.box(false), shape = this.deep ? 0.55 : (y[1] - y[0]) / (x[1] - x[0]);
    const height = Math.max(220, Math.min(560, Math.round(width * shape * 1.04)));
    const size = [Math.round(ratio * width), Math.round(ratio * height)];
    if (!this.raster || this.raster.width !== size[0] || this.raster.height !== size[1]) {
      const first = !this.raster;
      [this.canvas.width, this.canvas.height] = size;
      this.canvas.style.height = `${height}px`;
      this.raster = new Raster(...size, this.deep);
      this.ratio = ratio;
      this.fit(first && width < 600);
    }
    this.draw();
  }

  request() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  draw() {
    const {raster} = this;
    if (!raster) return;
    const [low, high] = this.limits(), scale = 256 / (high - low);
    raster.clear(packed(...rgb(color('--paper'))));
    for (const layer of this.layers) {
      layer.move(this.frame, this.times);
      this.view.project(layer.drawn, layer.screen, raster.width, raster.height);
      // A cut may lie in the side of a body.
      if (layer.isBody) layer.screen.z.forEach((z, p, all) => { all[p] = z + 2 * this.ratio; });
      layer.read(this.frame, this.choice);
      for (let p = 0; p < layer.count; p++) layer.colors[p] = (layer.values[p] - low) * scale;
      if (layer.shown) this.fill(layer);
    }
    for (const layer of this.layers) if (layer.shown) this.lines(layer);
    this.canvas.getContext('2d').putImageData(raster.image, 0, 0);
    this.time.textContent = this.scene.times.length > 1 ? `t = ${digits(this.scene.times[this.frame], 6)} s` : '';
    [low, (low + high) / 2, high].forEach((value, n) => { this.ticks.children[n].textContent = digits(value, 4); });
    this.legend.textContent = labelled(this.choice.symbol, this.choice.unit);
    this.tell();
  }

  fill(layer) {
    const {raster, palette, choice: {body}} = this, {screen, screen: {x, y, z}, colors, solid} = layer;
    const plain = packed(205, 205, 205), none = new Float32Array(layer.count).fill(NaN);
    layer.triangles((a, b, c, cell) => {
      const has = body === 'all' || (body === 'solid') === (solid[cell] === 1);
      let from = 0, grey = plain;
      if (this.deep) {
        const light = layer.isBody ? brightness(x, y, z, a, b, c) : 1, shade = Math.min(15, Math.floor(16 * light));
        from = 256 * shade;
        const g = Math.round(205 * (0.45 + 0.55 * light));
        grey = packed(g, g, g);
      }
      raster.triangle(screen, has ? colors : none, a, b, c, palette, from, grey);
    });
  }

  lines(layer) {
    const {raster, ratio} = this, bias = this.deep ? 2 * ratio : 0;
    if (this.mesh) {
      for (let i = 0; i < layer.inner.length; i += 2) {
        raster.line(layer.screen, layer.inner[i], layer.inner[i + 1], [0, 0, 0], 0.35, 0.7 * ratio, bias);
      }
    }
    for (let i = 0; i < layer.outline.length; i += 2) {
      raster.line(layer.screen, layer.outline[i], layer.outline[i + 1], [0, 0, 0], 0.9, 1.2 * ratio, bias);
    }
  }

  /** What is under the pointer. */
  under() {
    if (!this.pointer) return null;
    const found = this.layers.filter(layer => layer.shown).map(layer => layer.find(...this.pointer)).filter(Boolean);
    const hit = found.sort((a, b) => b.depth - a.depth)[0];
    if (!hit) return null;
    const {layer, points, weights, cell} = hit, {body} = this.choice;
    const sum = values => weights.reduce((total, weight, n) => total + weight * values[points[n]], 0);
    const has = body === 'all' || (body === 'solid') === (layer.solid[cell] === 1);
    return {at: layer.at.map(sum), value: has ? layer.between(hit, this.frame, this.choice) : NaN};
  }

  tell() {
    const found = this.under();
    if (!found) {
      this.readout.textContent = '\u00a0';
      return;
    }
    const axes = this.scene.axes ?? ['x', 'y', 'z'];
    const at = found.at.map((x, d) => `${axes[d]} = ${digits(x, 5)} m`).join(', ');
    this.readout.textContent = `${at}: ${this.choice.symbol} = ${digits(found.value, 5)} ${this.choice.unit}`;
  }
}

/** How bright a triangle is that a lamp above and to the left of the viewer shines on. */
function brightness(x, y, z, a, b, c) {
  const ux = x[b] - x[a], uy = y[b] - y[a], uz = z[b] - z[a], wx = x[c] - x[a], wy = y[c] - y[a], wz = z[c] - z[a];
  const nx = uy * wz - uz * wy, ny = uz * wx - ux * wz, nz = ux * wy - uy * wx;
  const size = Math.hypot(nx, ny, nz);
  // The side that is seen; y is down.
  const side = nz < 0 ? -1 : 1;
  return size > 0 ? Math.max(0, side * (-0.2 * nx - 0.35 * ny + 0.92 * nz) / size) : 1;
}
