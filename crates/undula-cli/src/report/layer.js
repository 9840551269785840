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
    this.cells.forEach((p, i) => { this.within[this.solid[Math.floor(i / this.corners)] ? 'solid' : 'fluid'][p] = 1; });
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

  /** The triangle at a pixel: corners, weights and depth; the nearest one, `null` where there is none. */
  find(px, py) {
    const {x, y, z} = this.screen;
    let found = null;
    this.triangles((a, b, c, cell) => {
      const ux = x[b] - x[a], uy = y[b] - y[a], wx = x[c] - x[a], wy = y[c] - y[a], area = ux * wy - wx * uy;
      const s = ((px - x[a]) * wy - (py - y[a]) * wx) / area, t = ((py - y[a]) * ux - (px - x[a]) * uy) / area;
      if (!(s >= 0 && t >= 0 && s + t <= 1)) return;
      const depth = z[a] + s * (z[b] - z[a]) + t * (z[c] - z[a]);
      if (!found || depth > found.depth) found = {corners: [a, b, c], weights: [1 - s - t, s, t], depth, cell, layer: this};
    });
    return found;
  }
}
