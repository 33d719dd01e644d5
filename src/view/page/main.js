// Puts the parts together, and lets an address name a time and a net: page.html#t=120&net=line.f

const trace = new Trace(JSON.parse(document.getElementById("data").textContent));
const data = JSON.parse(document.getElementById("data").textContent);
const cursor = new Cursor(trace);
const schematic = new Schematic(document.getElementById("schematic"), cursor);
const waveform = new Waveform(document.getElementById("waveform"), cursor);
const route = new Route(document.getElementById("route"), cursor, data.route);

const redraw = () => {
  waveform.palette = null;
  waveform.draw();
  if (data.route) {
    route.paint();
    route.draw();
  }
};
const controls = new Controls(cursor, waveform, redraw);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
document.body.classList.toggle("with-schematic", Boolean(schematic.svg));

// how much of the window the waveform has
const split = document.getElementById("split");
const share = (part) => document.body.style.setProperty("--share", `${Math.min(Math.max(part, 0.15), 0.85) * 100}%`);
split.addEventListener("pointerdown", (event) => split.setPointerCapture(event.pointerId));
split.addEventListener("pointermove", (event) => {
  const { bottom, height } = document.getElementById("panels").getBoundingClientRect();
  if (event.buttons & 1) share((bottom - event.clientY) / height);
});
split.addEventListener("keydown", (event) => {
  const by = { ArrowUp: 0.05, ArrowDown: -0.05 }[event.key];
  if (!by) return;
  event.stopPropagation();
  const panels = document.getElementById("panels").getBoundingClientRect();
  share(document.getElementById("waveform").getBoundingClientRect().height / panels.height + by);
});

const follow = () => {
  const asked = new URLSearchParams(location.hash.slice(1));
  const net = trace.names.get(asked.get("net") ?? "") ?? trace.signals.find((s) => s.own === asked.get("net"));
  if (net) {
    cursor.select(net);
    waveform.reveal(net);
  }
  if (asked.get("theme")) document.documentElement.dataset.theme = asked.get("theme");
  cursor.seek(asked.has("t") ? Number(asked.get("t")) : cursor.time);
};
addEventListener("hashchange", follow);
waveform.resize();
follow();
redraw();

// for programs that drive the page
window.discreta = { trace, cursor, schematic, waveform, route, controls };
