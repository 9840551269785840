'use strict';
// Buttons, lists, keys and gestures of the player.

/** Makes the picture of a player and all that is around it. */
function buildControls(player) {
  const {scene, into} = player, many = scene.times.length > 1;
  player.canvas = element('canvas', {tabindex: 0, role: 'img', 'aria-label': 'fields of the run'});
  player.stage = element('div', {class: 'stage'}, player.canvas);
  const button = (text, label, click) => {
    return element('button', {type: 'button', 'aria-label': label, title: label, onclick: click}, text);
  };
  player.buttons = {
    back: button('‹', 'one moment back (←)', () => { player.play(false); player.setFrame(player.frame - 1); }),
    play: button('▶', 'play', () => player.play()),
    on: button('›', 'one moment on (→)', () => { player.play(false); player.setFrame(player.frame + 1); }),
  };
  player.slider = element('input', {
    type: 'range', min: 0, max: scene.times.length - 1, value: player.frame, 'aria-label': 'moment',
    oninput: () => { player.play(false); player.setFrame(Number(player.slider.value)); },
  });
  player.time = element('output', {class: 'time'});
  const speeds = [2, 5, 10, 20, 40].map(n => [n, `${n} a second`]);
  player.lists = {
    quantity: choice('quantity', player.choices.map(({label}, n) => [n, label]), 0, n => player.setChoice(Number(n))),
    map: choice('colours', Object.keys(player.maps).map(name => [name, name]), 'viridis', name => {
      player.chosenMap = true;
      player.setMap(name);
    }),
    range: choice('range of colours', [['all', 'all moments'], ['this', 'this moment']], 'all', kind => {
      player.fixed = kind === 'all';
      player.request();
    }),
    speed: choice('speed', speeds, player.speed, n => { player.speed = Number(n); }),
    times: choice('displacement', [1, 2, 5, 10, 100, 1000, 0].map(n => [n, `displacement × ${n}`]), 1, n => {
      player.times = Number(n);
      player.request();
    }),
  };
  player.meshBox = checkbox(false, on => { player.mesh = on; player.request(); });
  player.bar = element('div', {class: 'bar-of-colors'});
  player.ticks = element('div', {class: 'ticks'}, element('span'), element('span'), element('span'));
  player.legend = element('div', {class: 'legend'});
  player.readout = element('output', {class: 'readout'}, '\u00a0');
  const tools = [
    player.lists.quantity, player.lists.map, ...(many ? [player.lists.range] : []),
    ...(player.moves ? [player.lists.times] : []),
    element('label', {}, player.meshBox, ' mesh'),
    button('+', 'enlarge (+)', () => zoomBy(player, 1.5)),
    button('−', 'reduce (−)', () => zoomBy(player, 1 / 1.5)),
    button('all', 'show all (0)', () => player.fit()),
  ];
  if (player.layers.some(layer => layer.solid.some(Boolean)) && player.box(true)) {
    tools.push(button('bodies', 'show the bodies (b)', () => player.fit(true)));
  }
  if (player.layers.length > 1) tools.push(...player.layers.map(layer => layerBox(player, layer)));
  const {back, play, on} = player.buttons;
  into.replaceChildren(
    player.stage, player.readout,
    element('div', {class: 'colors'}, player.legend, element('div', {}, player.bar, player.ticks)),
    ...(many ? [controls(back, play, on, player.slider, player.time, player.lists.speed)] : []),
    controls(...tools),
    element('p', {class: 'data'}, `Drag to ${player.deep ? 'turn, with Shift to ' : ''}move; pinch, or turn the wheel `
      + 'after a click, to enlarge. Keys: space plays, ← → step, + − enlarge and reduce, 0 shows all, b the bodies, '
      + 'm the mesh, q the next quantity.'),
  );
}

const controls = (...parts) => element('div', {class: 'controls'}, ...parts);

function checkbox(checked, change) {
  const box = element('input', {type: 'checkbox', checked, onchange: () => change(box.checked)});
  return box;
}

function layerBox(player, layer) {
  const box = checkbox(true, on => { layer.shown = on; player.request(); });
  return element('label', {}, box, ` ${layer.name}`);
}

function zoomBy(player, factor, dx = 0, dy = 0) {
  player.view.zoom(factor, dx, dy);
  // A finger scrolls the page as long as all is seen.
  player.canvas.style.touchAction = player.deep || player.view.scale > 1.01 * player.view.base ? 'none' : 'pan-y';
  player.request();
}

/** Keys and pointers. */
function listenTo(player) {
  const {canvas} = player, fingers = new Map();
  const place = event => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top].map(x => x * player.ratio);
  };
  canvas.style.touchAction = player.deep ? 'none' : 'pan-y';
  canvas.addEventListener('pointerdown', event => {
    fingers.set(event.pointerId, place(event));
    canvas.setPointerCapture(event.pointerId);
    player.pointer = place(event);
    player.request();
  });
  canvas.addEventListener('pointermove', event => {
    const now = place(event), before = fingers.get(event.pointerId);
    player.pointer = now;
    if (before) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
      if (other) pinch(player, before, now, other);
      else if (player.deep && !event.shiftKey) turnBy(player, now[0] - before[0], now[1] - before[1]);
      else player.view.pan(now[0] - before[0], now[1] - before[1]);
      fingers.set(event.pointerId, now);
    }
    player.request();
  });
  for (const name of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(name, event => fingers.delete(event.pointerId));
  }
  canvas.addEventListener('pointerleave', event => {
    if (event.pointerType === 'mouse') player.pointer = null;
    player.request();
  });
  canvas.addEventListener('wheel', event => {
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    const [x, y] = place(event);
    zoomBy(player, Math.exp(-event.deltaY / 400), x - canvas.width / 2, y - canvas.height / 2);
  }, {passive: false});
  canvas.addEventListener('dblclick', () => player.fit());
  canvas.addEventListener('keydown', event => {
    const act = key(player, event);
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  });
}

function turnBy(player, dx, dy) {
  const {view, ratio} = player;
  view.turn(view.azimuth + 0.008 * dx / ratio, view.elevation + 0.008 * dy / ratio);
}

function pinch(player, before, now, other) {
  const {canvas} = player, apart = p => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
  const middle = [0, 1].map(d => (now[d] + other[d]) / 2);
  player.view.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
  zoomBy(player, apart(now) / apart(before), middle[0] - canvas.width / 2, middle[1] - canvas.height / 2);
}

function key(player, {key, shiftKey}) {
  const step = 40 * player.ratio, move = (dx, dy) => () => { player.view.pan(dx, dy); player.request(); };
  const moved = {
    ArrowLeft: move(step, 0), ArrowRight: move(-step, 0), ArrowUp: move(0, step), ArrowDown: move(0, -step),
  };
  if (shiftKey && moved[key]) return moved[key];
  const to = frame => () => { player.play(false); player.setFrame(frame); };
  const next = () => player.setChoice((player.choices.indexOf(player.choice) + 1) % player.choices.length);
  return {
    ' ': () => player.play(), ArrowLeft: to(player.frame - 1), ArrowRight: to(player.frame + 1),
    Home: to(0), End: to(player.scene.times.length - 1),
    '+': () => zoomBy(player, 1.5), '=': () => zoomBy(player, 1.5), '-': () => zoomBy(player, 1 / 1.5),
    0: () => player.fit(), b: () => player.fit(true), q: next,
    m: () => { player.meshBox.click(); },
  }[key];
}
