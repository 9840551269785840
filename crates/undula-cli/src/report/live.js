'use strict';
// The page while the run goes on: rows come as server-sent events.

/** Numbers with others behind them. */
function longer(numbers, others) {
  const all = new Float64Array(numbers.length + others.length);
  all.set(numbers);
  all.set(others, numbers.length);
  return all;
}

/** Follows the run after what is on the page. */
async function follow() {
  await globalThis.undula.ready;
  const bar = element('p', {class: 'live', role: 'status'}, 'waiting for the next step');
  document.querySelector('h1').after(bar);
  const charts = globalThis.undula.histories;
  const source = new EventSource(`/events?after=${report.step}`);
  source.onmessage = ({data}) => {
    const {rows, end} = JSON.parse(data);
    // A page without a step has no charts yet.
    if (rows.length && !charts) return location.reload();
    for (const {name, chart, factor, force} of charts ?? []) {
      const value = row => (row.values[name] ?? row.counts[name] ?? NaN) * factor;
      chart.x = longer(chart.x, rows.map(row => force ? row.force_time : row.time));
      chart.y = longer(chart.y, rows.map(value));
      if (rows.length) chart.draw();
    }
    const last = rows[rows.length - 1];
    if (last) {
      const load = {type: 'button', onclick: () => location.reload()};
      const told = `step ${last.step}, t = ${digits(last.time, 6)} s, ${last.counts.newton_steps} Newton iterations `;
      bar.replaceChildren(told, element('button', load, 'load fields and tables anew'));
    }
    if (end) {
      source.close();
      bar.replaceChildren(`The run has ended: ${end}. Its page is report.html in its directory.`);
    }
  };
}
follow();
