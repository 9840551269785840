'use strict';
// From metres to pixels: plane fields are moved and enlarged, bodies in space are turned, too.

/** The way in which a scene is looked at. Distances in `middle` are metres, `scale` is pixels per metre. */
class View {
  constructor(dimension) {
    this.dimension = dimension;
    this.middle = [0, 0, 0];
    this.scale = 1;
    this.turn(-0.5, 0.45);
  }

  /** Looks from `azimuth` around the axis that is up, y, and from `elevation` above. */
  turn(azimuth, elevation) {
    this.azimuth = azimuth;
    this.elevation = Math.max(-1.57, Math.min(1.57, elevation));
    const [s, c, t, d] = [Math.sin(azimuth), Math.cos(azimuth), Math.sin(this.elevation), Math.cos(this.elevation)];
    const turned = [[c, 0, s], [t * s, d, -t * c], [-d * s, t, d * c]];
    this.axes = this.dimension === 2 ? [[1, 0, 0], [0, 1, 0], [0, 0, 1]] : turned;
  }

  /** Shows a box, `[[x, x], [y, y], [z, z]]`, in a picture of `width` and `height` pixels. */
  fit(box, width, height) {
    this.middle = box.map(([low, high]) => 0.5 * (low + high));
    const reach = axis => axis.reduce((sum, a, d) => sum + Math.abs(a) * (box[d][1] - box[d][0]), 0);
    const across = reach(this.axes[0]) || 1, up = reach(this.axes[1]) || 1;
    this.scale = 0.97 * Math.min(width / across, height / up);
    this.base = this.scale;
  }

  /** Writes the pixels of points, arrays by coordinate, to `to`. */
  project(points, to, width, height) {
    const [x, y, z = null] = points, {middle: [mx, my, mz], scale, axes: [right, up, near]} = this;
    if (!z) {
      for (let p = 0; p < x.length; p++) {
        to.x[p] = 0.5 * width + scale * (x[p] - mx);
        to.y[p] = 0.5 * height - scale * (y[p] - my);
      }
      return;
    }
    for (let p = 0; p < x.length; p++) {
      const a = x[p] - mx, b = y[p] - my, c = z[p] - mz;
      to.x[p] = 0.5 * width + scale * (right[0] * a + right[1] * b + right[2] * c);
      to.y[p] = 0.5 * height - scale * (up[0] * a + up[1] * b + up[2] * c);
      to.z[p] = scale * (near[0] * a + near[1] * b + near[2] * c);
    }
  }

  /** Moves the picture by pixels. */
  pan(dx, dy) {
    const [right, up] = this.axes;
    for (let d = 0; d < 3; d++) this.middle[d] -= (right[d] * dx - up[d] * dy) / this.scale;
  }

  /** Enlarges around a place, in pixels from the middle of the picture. */
  zoom(factor, dx, dy) {
    const former = this.scale;
    this.scale = Math.max(0.3 * this.base, Math.min(1000 * this.base, factor * former));
    const part = 1 - this.scale / former;
    this.pan(dx * part, dy * part);
  }
}
