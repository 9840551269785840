'use strict';
// Numbers of the page: base64, deflated, all first bytes before all second ones. See arrays.rs.

const report = JSON.parse(document.getElementById('report-data').textContent);

/** Inflates the text of an array to bytes. */
async function inflate(text) {
  const deflated = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Numbers of `width` bytes each from their planes, as a buffer. */
function joined(planes, width) {
  const n = planes.length / width, bytes = new Uint8Array(planes.length);
  for (let byte = 0; byte < width; byte++) {
    for (let i = 0; i < n; i++) bytes[width * i + byte] = planes[byte * n + i];
  }
  return bytes.buffer;
}

/** An array of the page as a typed array; a film as an array of moments, see `Film`. */
async function unpack(array) {
  const bytes = await inflate(array.data);
  switch (array.type) {
    case 'u8': return bytes;
    case 'f32': return new Float32Array(joined(bytes, 4));
    case 'f64': return new Float64Array(joined(bytes, 8));
    case 'u32': {
      const numbers = new Uint32Array(joined(bytes, 4));
      for (let i = 1; i < numbers.length; i++) numbers[i] += numbers[i - 1];
      return numbers;
    }
    default: return new Film(array, new Uint16Array(joined(bytes, 2)));
  }
}

/** The values of one quantity at all moments. */
class Film {
  constructor({frames, base, step, zero}, codes) {
    this.frames = frames;
    this.points = frames ? codes.length / frames : 0;
    Object.assign(this, {base, step, zero});
    for (let t = 0, i = 0; t < frames; t++) {
      for (let p = 0, left = 0; p < this.points; p++, i++) {
        const d = codes[i] >> 1 ^ -(codes[i] & 1);
        left = left + d & 65535;
        codes[i] = t ? codes[i - this.points] + left : left;
      }
    }
    this.codes = codes;
  }

  /** The value at a point, NaN where there is none. */
  value(frame, point) {
    const code = this.codes[frame * this.points + point];
    return code === 65535 ? NaN : this.base + this.step * (code - this.zero);
  }

  /** Writes the values of a moment to `to`. */
  read(frame, to) {
    for (let p = 0; p < this.points; p++) to[p] = this.value(frame, p);
    return to;
  }
}

/** `x` with some significant digits, as people write it. */
function digits(x, count = 5) {
  if (!Number.isFinite(x)) return '–';
  const size = Math.abs(x);
  const small = size && (size < 1e-4 || size >= 1e7), rounded = Number(x.toPrecision(count));
  const text = small ? rounded.toExponential() : String(rounded);
  return text.replace('e+', 'e').replaceAll('-', '−');
}

/** Name with unit. */
const labelled = (name, unit) => unit ? `${name} [${unit}]` : name;

/** An element with attributes and children. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, '');
    else if (value !== false && value != null) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/** A box to choose from. */
function choice(label, options, chosen, change) {
  const items = options.map(([value, text]) => element('option', {value, selected: value === chosen}, text));
  const select = element('select', {onchange: () => change(select.value), 'aria-label': label}, ...items);
  return select;
}

/** Whether the page is printed now: paper is white. */
let printing = false;

/** The value of a colour of the style sheet. */
function color(name) {
  if (printing) return {'--ink': '#222', '--paper': '#fff', '--faint': '#666', '--line': '#ddd'}[name] ?? '#fff';
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Pictures that are drawn anew where colours or sizes change. */
const pictures = [];
const redraw = () => pictures.forEach(picture => picture.resize());
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
addEventListener('beforeprint', () => { printing = true; redraw(); });
addEventListener('afterprint', () => { printing = false; redraw(); });
