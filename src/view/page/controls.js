// Buttons, keys and the search: all that moves the cursor besides the pictures themselves.

const RATES = [1, 2, 5, 10, 30, 100, 1000, 10000];

class Controls {
  constructor(cursor, waveform, redraw) {
    Object.assign(this, { cursor, waveform, redraw });
    const { trace } = cursor;
    this.of = (id) => document.getElementById(id);
    const on = (id, act) => this.of(id).addEventListener("click", act);
    on("first", () => cursor.seek(trace.start));
    on("last", () => cursor.seek(trace.end));
    on("back", () => cursor.step(-1));
    on("forth", () => cursor.step(1));
    on("play", () => cursor.play(!cursor.playing));
    on("net-back", () => cursor.jump(cursor.selected, -1));
    on("net-forth", () => cursor.jump(cursor.selected, 1));
    on("theme", () => this.theme());
    on("ask", () => this.help());
    this.of("help").querySelector(".close").addEventListener("click", () => this.of("help").close());
    this.scrub = this.of("scrub");
    this.scrub.min = trace.start;
    this.scrub.max = Math.max(trace.end, trace.start);
    this.scrub.addEventListener("input", () => cursor.seek(Number(this.scrub.value)));
    const speed = this.of("speed");
    speed.append(...RATES.map((rate) => new Option(`${rate}/s`, rate, false, rate === cursor.rate)));
    speed.addEventListener("change", () => (cursor.rate = Number(speed.value)));
    this.found = { text: "", n: 0 };
    const search = this.of("search");
    search.addEventListener("input", () => this.find(search.value, 0));
    search.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.find(search.value, event.shiftKey ? -1 : 1);
      if (event.key === "Escape") search.blur();
    });
    addEventListener("keydown", (event) => this.key(event));
    cursor.watch((what) => this.show(what));
    this.show("time");
    this.show("selection");
  }
  show(what) {
    const { cursor } = this;
    if (what === "time") {
      this.scrub.value = cursor.time;
      this.of("now").textContent = cursor.trace.time(cursor.time, 12);
    } else if (what === "playing") {
      const play = this.of("play");
      play.setAttribute("aria-pressed", String(cursor.playing));
      play.setAttribute("aria-label", cursor.playing ? "Stop" : "Play");
      // a reader of the screen need not follow every frame
      this.of("now").setAttribute("aria-live", cursor.playing ? "off" : "polite");
    } else if (what === "selection") {
      this.of("net").textContent = cursor.selected ? cursor.selected.own : "no net";
      for (const id of ["net-back", "net-forth"]) this.of(id).disabled = !cursor.selected;
    }
  }
  /// Selects the signal whose name fits best, or one of the next that fit.
  find(text, by) {
    const search = this.of("search");
    const wanted = text.trim().toLowerCase();
    if (!wanted) return search.removeAttribute("aria-invalid");
    const rank = (signal) => {
      const [own, name] = [signal.own.toLowerCase(), signal.name.toLowerCase()];
      if (own === wanted || name === wanted) return 0;
      if (own.startsWith(wanted)) return 1;
      return own.includes(wanted) ? 2 : name.includes(wanted) ? 3 : 4;
    };
    const fitting = this.cursor.trace.signals.filter((signal) => !signal.hidden && rank(signal) < 4);
    fitting.sort((a, b) => rank(a) - rank(b) || a.path.length - b.path.length);
    this.found = { text: wanted, n: this.found.text === wanted ? this.found.n + by : 0 };
    search.setAttribute("aria-invalid", String(!fitting.length));
    if (!fitting.length) return;
    const signal = fitting[((this.found.n % fitting.length) + fitting.length) % fitting.length];
    this.cursor.select(signal);
    this.waveform.reveal(signal);
  }
  theme() {
    const root = document.documentElement;
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    this.redraw();
  }
  help() {
    const help = this.of("help");
    help.open ? help.close() : help.showModal();
  }
  faster(by) {
    const n = Math.min(Math.max(RATES.indexOf(this.cursor.rate) + by, 0), RATES.length - 1);
    this.cursor.rate = RATES[n];
    this.of("speed").value = String(RATES[n]);
  }
  radix() {
    const { selected } = this.cursor;
    if (!selected || (selected.width < 2 && !selected.values)) return;
    selected.nextRadix();
    this.cursor.tell("radix");
    this.waveform.draw();
  }
  analog() {
    const { selected } = this.cursor;
    if (!selected || (selected.width < 2 && selected.kind !== "real")) return;
    selected.analog = !selected.analog;
    this.waveform.draw();
  }
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { target } = event;
    if (target.matches("input[type=search], select")) return;
    // what a button or the slider does with a key is not taken from it
    if (target.matches("button, [role=separator]") && (event.key === "Enter" || event.key === " ")) return;
    const { cursor, waveform } = this;
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const acts = {
      " ": () => cursor.play(!cursor.playing),
      ",": () => cursor.edge(-1),
      ".": () => cursor.edge(1),
      Home: () => cursor.seek(cursor.trace.start),
      End: () => cursor.seek(cursor.trace.end),
      "[": () => this.faster(-1),
      "]": () => this.faster(1),
      ArrowUp: () => waveform.beside(-1),
      ArrowDown: () => waveform.beside(1),
      r: () => this.radix(),
      a: () => this.analog(),
      "+": () => waveform.zoom(0.5),
      "=": () => waveform.zoom(0.5),
      "-": () => waveform.zoom(2),
      f: () => waveform.span(cursor.trace.start, cursor.trace.end),
      "/": () => this.of("search").focus(),
      d: () => this.theme(),
      "?": () => this.help(),
    };
    const act = by ? () => (event.shiftKey ? cursor.jump(cursor.selected, by) : cursor.step(by)) : acts[event.key] ?? acts[event.key.toLowerCase()];
    if (!act || (this.of("help").open && event.key !== "?")) return;
    event.preventDefault();
    act();
  }
}
