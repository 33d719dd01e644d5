// Measures how long a frame takes while the cursor goes through a whole trace, and while the span of time changes.
(() => {
  const { cursor, trace, waveform } = window.discreta;
  const statistics = (list) => {
    list.sort((a, b) => a - b);
    return { median: list[list.length >> 1], worst: list[list.length - 1], frames: list.length };
  };
  // layout and style are part of a frame
  const timed = (act) => {
    const from = performance.now();
    act();
    document.body.getBoundingClientRect();
    return performance.now() - from;
  };
  const play = [];
  const scrub = [];
  const zoom = [];
  cursor.seek(trace.start);
  for (let n = 0; n < 300; n++) play.push(timed(() => cursor.step(1)));
  for (let n = 0; n < 300; n++) scrub.push(timed(() => cursor.seek(trace.start + Math.round((((n * 7919) % 1000) / 1000) * (trace.end - trace.start)))));
  waveform.span(trace.start, trace.end);
  for (let n = 0; n < 40; n++) zoom.push(timed(() => (n < 20 ? waveform.zoom(0.7) : waveform.zoom(1 / 0.7))));
  const pre = document.createElement("pre");
  pre.id = "seen";
  const changes = trace.signals.reduce((n, s) => n + s.changes.count, 0);
  pre.textContent = JSON.stringify({ changes, instants: trace.times.length, play: statistics(play), scrub: statistics(scrub), zoom: statistics(zoom) });
  document.body.append(pre);
})();
