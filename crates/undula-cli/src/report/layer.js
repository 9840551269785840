'use strict';
// Cells, their lines and the values at their points.

/** Part of a scene: points that move, cells between them, quantities. */
class Layer {
  static async unpack(stored, moves) {
    const all = arrays => Promise.all(arrays.map(unpack));
    const layer = new Layer();
    layer.name = stored.name;
    layer.corners = stored.corners;
    layer.base = await all(stored.points);
    layer.cells = await unpack(stored.cells);
    layer.solid = await unpack(stored.solid);
    layer.inner = await unpack(stored.inner);
    layer.outline = await unpack(stored.outline);
    layer.quantities = await Promise.all(stored.quantities.map(all));
    layer.motion = moves === null ? stored.motion && await all(stored.motion) : layer.quantities[moves];
    layer.prepare();
    return layer;
  }

  prepare() {
    const n = this.count = this.base[0].length;
    this.shown = true;
    this.isBody = this.name === 'bodies';
    this.at = this.base.map(x => Float32Array.from(x));
    this.drawn = this.base.map(x => Float32Array.from(x));
    this.screen = {x: new Float32Array(n), y: new Float32Array(n), z: new Float32Array(n)};
    this.values = new Float32Array(n);
    this.colors = new Float32Array(n);
    this.scratch = new Float32Array(n);
    // Which points belong to fluid cells, which to solid ones.
    this.within = {fluid: new Uint8Array(n), solid: new Uint8Array(n), all: new Uint8Array(n).fill(1)};
    const body = i => this.solid[Math.floor(i / this.corners)] ? 'solid' : 'fluid';
    this.cells.forEach((p, i) => { this.within[body(i)][p] = 1; });
  }

  /** Moves the points to where they are at a moment, and for the picture `times` as far. */
  move(frame, times) {
    if (!this.motion) return;
    this.motion.forEach((film, d) => {
      const u = film.read(frame, this.scratch), base = this.base[d];
      for (let p = 0; p < this.count; p++) {
        this.at[d][p] = base[p] + u[p];
        this.drawn[d][p] = base[p] + times * u[p];
      }
    });
  }

  /** Writes the values of a component of a quantity, or of its size, to `to`. */
  read(frame, {quantity, component, factor}, to = this.values) {
    const films = this.quantities[quantity];
    if (component !== null) {
      films[component].read(frame, to);
      for (let p = 0; p < this.count; p++) to[p] *= factor;
      return to;
    }
    to.fill(0);
    for (const film of films) {
      const part = film.read(frame, this.scratch);
      for (let p = 0; p < this.count; p++) to[p] += part[p] * part[p];
    }
    for (let p = 0; p < this.count; p++) to[p] = factor * Math.sqrt(to[p]);
    return to;
  }

  /** Least and greatest drawn coordinates, of the points of bodies alone where that is asked for. */
  box(bodies) {
    return this.drawn.map(x => {
      let low = Infinity, high = -Infinity;
      for (let p = 0; p < this.count; p++) {
        if (bodies && !this.within.solid[p]) continue;
        low = Math.min(low, x[p]);
        high = Math.max(high, x[p]);
      }
      return [low, high];
    });
  }

  /** Calls `draw` with the corners of every triangle and the number of its cell. */
  triangles(draw) {
    const {cells, corners} = this;
    if (corners === 3) {
      for (let i = 0, cell = 0; i < cells.length; i += 3, cell++) draw(cells[i], cells[i + 1], cells[i + 2], cell);
      return;
    }
    for (let i = 0, cell = 0; i < cells.length; i += 4, cell++) {
      draw(cells[i], cells[i + 1], cells[i + 3], cell);
      draw(cells[i], cells[i + 3], cells[i + 2], cell);
    }
  }

  /** The cell at a pixel: corners with their weights, and depth; the nearest one, `null` where there is none. */
  find(px, py) {
    const {x, y, z} = this.screen, {cells, corners} = this;
    let found = null;
    for (let i = 0, cell = 0; i < cells.length; i += corners, cell++) {
      const points = cells.subarray(i, i + corners);
      if (points.every(p => x[p] < px) || points.every(p => x[p] > px)) continue;
      if (points.every(p => y[p] < py) || points.every(p => y[p] > py)) continue;
      const weights = weightsAt(points, x, y, px, py);
      if (!weights) continue;
      const depth = weights.reduce((sum, weight, n) => sum + weight * z[points[n]], 0);
      if (!found || depth > found.depth) found = {points, weights, depth, cell, layer: this};
    }
    return found;
  }

  /** A component or the size of a quantity between points with weights. */
  between({points, weights}, frame, {quantity, component, factor}) {
    const sum = film => weights.reduce((total, weight, n) => total + weight * film.value(frame, points[n]), 0);
    const films = this.quantities[quantity];
    return factor * (component === null ? Math.hypot(...films.map(sum)) : sum(films[component]));
  }
}

/** Weights of the corners of a cell at a place, linear or bilinear; `null` if the place is outside of it. */
function weightsAt(points, x, y, px, py) {
  const [a, b, c, d] = points;
  const triangle = points.length === 3;
  const twist = triangle ? [0, 0] : [x[a] - x[b] - x[c] + x[d], y[a] - y[b] - y[c] + y[d]];
  let r = 0.4, s = 0.4;
  for (let n = 0; n < (triangle ? 1 : 8); n++) {
    const fx = x[a] + r * (x[b] - x[a]) + s * (x[c] - x[a]) + r * s * twist[0] - px;
    const fy = y[a] + r * (y[b] - y[a]) + s * (y[c] - y[a]) + r * s * twist[1] - py;
    const rx = x[b] - x[a] + s * twist[0], ry = y[b] - y[a] + s * twist[1];
    const sx = x[c] - x[a] + r * twist[0], sy = y[c] - y[a] + r * twist[1];
    const area = rx * sy - sx * ry;
    r -= (fx * sy - sx * fy) / area;
    s -= (rx * fy - fx * ry) / area;
  }
  const low = -1e-6, high = 1 - low;
  if (!(r >= low && s >= low && (triangle ? r + s <= high : r <= high && s <= high))) return null;
  return triangle ? [1 - r - s, r, s] : [(1 - r) * (1 - s), r * (1 - s), (1 - r) * s, r * s];
}
