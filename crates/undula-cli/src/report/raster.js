'use strict';
// Pixels: triangles with a value at each corner, and lines. No part of the page needs a graphics processor.

/** A picture; rows from above. `deep`: what is in front hides what is behind. */
class Raster {
  constructor(width, height, deep) {
    this.width = width;
    this.height = height;
    this.image = new ImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.depth = deep ? new Float32Array(width * height) : null;
  }

  clear(color) {
    this.pixels.fill(color);
    this.depth?.fill(-Infinity);
  }

  /**
   * A triangle between the points `a`, `b`, `c` of the arrays x, y, z (pixels) and v (numbers of colours). `colors`
   * has 256 of them from `from` on; a triangle without values is `plain`.
   */
  triangle({x, y, z}, v, a, b, c, colors, from, plain) {
    const {width, height, pixels, depth} = this;
    const x0 = x[a], y0 = y[a], ux = x[b] - x0, uy = y[b] - y0, wx = x[c] - x0, wy = y[c] - y0;
    const area = ux * wy - wx * uy;
    if (!(area < 0 || area > 0)) return;
    const low = Math.min(y0, y[b], y[c]), high = Math.max(y0, y[b], y[c]);
    const first = Math.max(0, Math.ceil(low - 0.5)), last = Math.min(height - 1, Math.ceil(high - 0.5) - 1);
    if (last < first || Math.max(x0, x[b], x[c]) < 0 || Math.min(x0, x[b], x[c]) > width) return;
    const has = v[a] + v[b] + v[c], flat = has !== has;
    const p = v[b] - v[a], q = v[c] - v[a];
    const vx = (p * wy - q * uy) / area, vy = (q * ux - p * wx) / area;
    let zx = 0, zy = 0;
    if (depth) {
      const r = z[b] - z[a], s = z[c] - z[a];
      zx = (r * wy - s * uy) / area;
      zy = (s * ux - r * wx) / area;
    }
    for (let row = first; row <= last; row++) {
      const at = row + 0.5;
      let left = Infinity, right = -Infinity;
      for (let side = 0; side < 3; side++) {
        let i = side === 0 ? a : side === 1 ? b : c, j = side === 0 ? b : side === 1 ? c : a;
        if (y[i] > y[j]) { const k = i; i = j; j = k; }
        if (at < y[i] || at >= y[j]) continue;
        const cross = x[i] + (at - y[i]) * (x[j] - x[i]) / (y[j] - y[i]);
        if (cross < left) left = cross;
        if (cross > right) right = cross;
      }
      const begin = Math.max(0, Math.ceil(left - 0.5)), end = Math.min(width, Math.ceil(right - 0.5));
      let value = v[a] + (begin + 0.5 - x0) * vx + (at - y0) * vy;
      let near = depth ? z[a] + (begin + 0.5 - x0) * zx + (at - y0) * zy : 0;
      const stop = row * width + end;
      for (let i = row * width + begin; i < stop; i++, value += vx, near += zx) {
        if (depth) {
          if (near <= depth[i]) continue;
          depth[i] = near;
        }
        pixels[i] = flat ? plain : colors[from + (value > 0 ? value < 255 ? value | 0 : 255 : 0)];
      }
    }
  }

  /** A line, `wide` pixels, in [red, green, blue] with `alpha`; hidden by what is nearer by more than `bias`. */
  line({x, y, z}, a, b, [red, green, blue], alpha, wide, bias) {
    const {width, height, image: {data}, depth} = this;
    const steep = Math.abs(y[b] - y[a]) > Math.abs(x[b] - x[a]);
    const [s, t, lengths, widths] = steep ? [y, x, height, width] : [x, y, width, height];
    if (s[a] > s[b]) { const k = a; a = b; b = k; }
    const size = s[b] - s[a];
    if (!(s[b] >= 0 && s[a] <= lengths)) return;
    if (Math.max(t[a], t[b]) < -wide || Math.min(t[a], t[b]) > widths + wide) return;
    const slope = size > 0 ? (t[b] - t[a]) / size : 0, sinking = size > 0 && depth ? (z[b] - z[a]) / size : 0;
    const half = 0.5 * wide * Math.sqrt(1 + slope * slope);
    const begin = Math.round(s[a]), end = Math.max(Math.round(s[b]), begin + 1);
    const first = Math.max(0, begin), last = Math.min(lengths, end);
    for (let i = first; i < last; i++) {
      const middle = t[a] + (i + 0.5 - s[a]) * slope;
      const near = depth ? z[a] + (i + 0.5 - s[a]) * sinking + bias : 0;
      for (let j = Math.max(0, Math.floor(middle - half)); j < middle + half && j < widths; j++) {
        const cover = alpha * (Math.min(j + 1, middle + half) - Math.max(j, middle - half));
        const pixel = steep ? i * width + j : j * width + i;
        if (depth && near < depth[pixel]) continue;
        const at = 4 * pixel;
        data[at] += cover * (red - data[at]);
        data[at + 1] += cover * (green - data[at + 1]);
        data[at + 2] += cover * (blue - data[at + 2]);
        data[at + 3] = 255;
      }
    }
  }
}

/** 256 colours for each of `shades` brightnesses, from dark to bright, between equidistant `stops`. */
function palette(stops, shades) {
  const colors = new Uint32Array(256 * shades);
  for (let shade = 0; shade < shades; shade++) {
    const light = shades > 1 ? 0.45 + 0.55 * shade / (shades - 1) : 1;
    for (let n = 0; n < 256; n++) {
      const at = n / 255 * (stops.length - 1), i = Math.min(Math.floor(at), stops.length - 2), part = at - i;
      const [r, g, b] = stops[i].map((c, k) => Math.round(light * (c + part * (stops[i + 1][k] - c))));
      colors[256 * shade + n] = packed(r, g, b);
    }
  }
  return colors;
}

/** A pixel; computers with browsers are little-endian. */
const packed = (r, g, b) => (255 << 24 | b << 16 | g << 8 | r) >>> 0;

/** Red, green, blue of a colour of the style sheet, #rgb or #rrggbb. */
function rgb(text) {
  const hex = text.slice(1), wide = hex.length === 3 ? [...hex].map(c => c + c).join('') : hex;
  return [0, 2, 4].map(i => parseInt(wide.slice(i, i + 2), 16));
}
