'use strict';
// Fills the page with its pictures.

/** Histories over time, one below the other, and those of the solver. */
async function showHistories({time, force_time, signals, counts, window}) {
  const times = {false: await unpack(time), true: await unpack(force_time)}, group = new Group(), found = [];
  for (const [into, all] of [['history-charts', signals], ['count-charts', counts]]) {
    const place = document.getElementById(into);
    if (!place) continue;
    for (const [n, {name, label, unit, factor = 1, about, values, force, published = []}] of all.entries()) {
      const y = await unpack(values), x = times[force];
      const labels = ['t [s]', labelled(label, unit)];
      const ink = CURVES[n % CURVES.length];
      const chart = new Chart(place, {name, x, y, labels, about, lines: published, group, ink});
      found.push({name, x, y, unit, chart, factor, force});
    }
  }
  globalThis.undula.histories = found;
  const place = document.getElementById('periodic-charts');
  if (place) await showPeriodic(place, signals, found, window);
}

/** The spectrum and the phase portrait of a signal that is chosen, and the paths of points. */
async function showPeriodic(place, signals, found, [start, end]) {
  const periodic = signals.filter(signal => signal.spectrum), from = end - 5 * (end - start);
  const charts = element('div', {class: 'charts'});
  const late = ({x, y}) => {
    const n = Math.max(0, x.findIndex(t => t >= from));
    return [x.slice(n), y.slice(n)];
  };
  const graph = (name, x, y, labels, ink, path) => {
    new Chart(charts, {name, x, y, labels, about: name, path, ink: CURVES[ink]});
  };
  const show = async name => {
    const signal = periodic.find(signal => signal.name === name), {unit} = signal;
    pictures.splice(0, pictures.length, ...pictures.filter(picture => !charts.contains(picture.figure)));
    charts.replaceChildren();
    const frequencies = await unpack(signal.spectrum.frequencies);
    const amplitudes = await unpack(signal.spectrum.amplitudes);
    graph(`spectrum of ${name}`, frequencies, amplitudes, ['f [Hz]', labelled('amplitude', unit)], 0, false);
    const [t, y] = late(found.find(one => one.name === name));
    const inside = y.slice(1, -1), rate = inside.map((_, n) => (y[n + 2] - y[n]) / (t[n + 2] - t[n]));
    const labels = [labelled(name, unit), labelled(`d${name}/dt`, unit ? `${unit}/s` : '1/s')];
    graph(`phase portrait of ${name}`, inside, rate, labels, 1, true);
    const point = /^u[xy]_(.*)/.exec(name)?.[1], of = d => found.find(one => one.name === `u${d}_${point}`);
    if (point && of('x') && of('y')) {
      const [a, b] = [of('x'), of('y')];
      const labels = [labelled(a.name, a.unit), labelled(b.name, b.unit)];
      graph(`path of ${point}`, late(a)[1], late(b)[1], labels, 2, true);
    }
  };
  const first = periodic.find(signal => signal.name.startsWith('uy')) ?? periodic[0];
  place.append(choice('signal', periodic.map(({name}) => [name, name]), first.name, show), charts);
  await show(first.name);
}

async function showFields(scene, maps) {
  const layers = await Promise.all(scene.layers.map(layer => Layer.unpack(layer, scene.moves)));
  globalThis.undula.player = new Player(document.getElementById('player'), scene, layers, maps);
}

/** Links to all parts of the page. */
function showContents() {
  const link = ({id, textContent}) => element('a', {href: `#${id}`}, textContent);
  const links = [...document.querySelectorAll('h2[id]')].map(link);
  document.querySelector('h1').after(element('nav', {'aria-label': 'contents'}, ...links));
}

async function fillPage() {
  showContents();
  if (!globalThis.DecompressionStream) {
    document.getElementById('player')?.replaceChildren('This browser is too old for the pictures of this page.');
    return;
  }
  if (report.histories) await showHistories(report.histories);
  if (report.scene) await showFields(report.scene, report.maps);
}

/** For programs: the player, the histories, and a promise that all is there. */
globalThis.undula = {};
globalThis.undula.ready = fillPage();
