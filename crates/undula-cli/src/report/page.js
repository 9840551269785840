'use strict';
// Fills the page with its pictures.

/** Histories over time, one below the other, and those of the solver. */
async function showHistories({time, force_time, signals, counts, window}) {
  const times = {false: await unpack(time), true: await unpack(force_time)}, group = new Group(), found = [];
  for (const [into, all] of [['histories', signals], ['counts', counts]]) {
    const place = document.getElementById(into);
    if (!place) continue;
    for (const [n, {name, label, unit, about, values, force, published = []}] of all.entries()) {
      const y = await unpack(values), x = times[force];
      const labels = ['t [s]', labelled(label, unit)];
      const chart = new Chart(place, {name, x, y, labels, about, lines: published, group, ink: CURVES[n % CURVES.length]});
      found.push({name, x, y, unit, chart});
    }
  }
  const place = document.getElementById('periodic');
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
  const show = async name => {
    const signal = periodic.find(signal => signal.name === name), {unit} = signal;
    pictures.splice(0, pictures.length, ...pictures.filter(picture => !charts.contains(picture.figure)));
    charts.replaceChildren();
    const [frequencies, amplitudes] = [await unpack(signal.spectrum.frequencies), await unpack(signal.spectrum.amplitudes)];
    new Chart(charts, {name: `spectrum of ${name}`, x: frequencies, y: amplitudes, labels: ['f [Hz]', labelled('amplitude', unit)],
      about: `spectrum of ${name}`});
    const [t, y] = late(found.find(one => one.name === name));
    const rate = y.map((_, n) => {
      const [a, b] = [Math.max(0, n - 1), Math.min(y.length - 1, n + 1)];
      return (y[b] - y[a]) / (t[b] - t[a]);
    });
    new Chart(charts, {name: `phase portrait of ${name}`, x: y, y: rate, path: true, ink: CURVES[1],
      labels: [labelled(name, unit), labelled(`d${name}/dt`, unit ? `${unit}/s` : '1/s')], about: `phase portrait of ${name}`});
    const other = /^u[xy]_/.test(name) && found.filter(one => one.name.slice(2) === name.slice(2) && /^u[xy]_/.test(one.name));
    if (other && other.length === 2) {
      const [a, b] = other.sort((a, b) => a.name < b.name ? -1 : 1), point = name.slice(3);
      new Chart(charts, {name: `path of ${point}`, x: late(a)[1], y: late(b)[1], path: true, ink: CURVES[2],
        labels: [labelled(a.name, a.unit), labelled(b.name, b.unit)], about: `path of ${point}`});
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

/** For programs: the player, and a promise that all is there. */
globalThis.undula = {
  ready: (async () => {
    if (!globalThis.DecompressionStream) {
      document.getElementById('player')?.replaceChildren('This browser is too old for the pictures of this page.');
      return;
    }
    if (report.histories) await showHistories(report.histories);
    if (report.scene) await showFields(report.scene, report.maps);
  })(),
};
