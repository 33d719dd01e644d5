// The signals over time: names and values are a list that anyone can read, the levels beside it a canvas.

const ROW = 26;
const FONT = "12px ui-monospace, SFMono-Regular, Menlo, Consolas, 'DejaVu Sans Mono', monospace";

/// The colours of the style sheet, for what is no element.
const colours = () => {
  const style = getComputedStyle(document.documentElement);
  const names = ["paper", "ink", "soft", "grid", "accent", "high", "unknown", "floating", "ideal", "fill"];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--c-${name}`).trim()]));
};

/// Makes a canvas as fine as the screen; its context, and its size in CSS pixels.
const fit = (canvas, width, height) => {
  const ratio = window.devicePixelRatio || 1;
  const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return context;
};

/// The least of 1, 2, 5, 10, … that is not below a number.
const nice = (least) => {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((m) => m * power).find((step) => step >= least * (1 - 1e-9));
};

class Waveform {
  constructor(section, cursor) {
    this.section = section;
    this.cursor = cursor;
    this.trace = cursor.trace;
    this.scroll = section.querySelector(".scroll");
    this.list = section.querySelector(".names");
    this.canvas = section.querySelector(".rows");
    this.times = section.querySelector(".times");
    this.line = document.createElement("div");
    this.line.className = "cursor";
    section.append(this.line);
    this.closed = new Set();
    this.groups = this.group();
    this.whole();
    this.build();
    this.handle();
    cursor.watch((what) => {
      if (what === "selection") this.select();
      else if (what === "time") this.follow();
      if (what !== "playing") this.values(what === "radix");
    });
  }
  /// The scopes in the order of the file, each with its signals, clocks first.
  group() {
    const groups = new Map();
    for (const signal of this.trace.signals) {
      if (signal.hidden) continue;
      if (!groups.has(signal.path)) groups.set(signal.path, []);
      groups.get(signal.path).push(signal);
    }
    for (const list of groups.values()) list.sort((a, b) => b.clock - a.clock);
    const depth = (path) => path.split(".").length;
    const least = Math.min(...[...groups.keys()].map(depth));
    const large = this.trace.signals.length > 40;
    for (const path of groups.keys()) if (large && depth(path) > least) this.closed.add(path);
    return groups;
  }
  /// Makes the list of rows anew.
  build() {
    this.rows = [];
    const items = [];
    for (const [path, signals] of this.groups) {
      const closed = this.closed.has(path);
      const item = document.createElement("li");
      item.className = "scope";
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = path || "signals";
      button.setAttribute("aria-expanded", String(!closed));
      button.addEventListener("click", () => {
        closed ? this.closed.delete(path) : this.closed.add(path);
        this.build();
      });
      item.append(button);
      items.push(item);
      this.rows.push(null);
      if (closed) continue;
      for (const signal of signals) {
        const item = document.createElement("li");
        const button = document.createElement("button");
        button.type = "button";
        const name = document.createElement("span");
        const value = document.createElement("span");
        name.className = "name";
        name.textContent = signal.own;
        value.className = "value";
        button.append(name, value);
        button.title = signal.name + (signal.width > 1 ? `, ${signal.width} bits` : "");
        if (signal.port) item.dataset.port = signal.port;
        button.addEventListener("click", () => this.cursor.select(signal));
        item.append(button);
        items.push(item);
        this.rows.push({ signal, item, value, shown: null });
      }
    }
    this.list.replaceChildren(...items);
    this.select();
    this.draw();
    this.values(true);
  }
  whole() {
    const { start, end } = this.trace;
    this.from = start;
    this.to = Math.max(end, start + 1);
  }
  x(time) {
    return ((time - this.from) / (this.to - this.from)) * this.width;
  }
  time(x) {
    return this.from + (x / this.width) * (this.to - this.from);
  }
  /// Shows a span of time, at least a few ticks and at most all of it.
  span(from, to) {
    const { start, end } = this.trace;
    const all = Math.max(end - start, 1);
    const size = Math.min(Math.max(to - from, Math.min(all, 4)), all);
    const begin = Math.min(Math.max((from + to - size) / 2, start), start + all - size);
    if (begin === this.from && begin + size === this.to) return;
    this.from = begin;
    this.to = begin + size;
    this.draw();
  }
  zoom(factor, at = this.cursor.time) {
    const centre = at < this.from || at > this.to ? (this.from + this.to) / 2 : at;
    this.span(centre - (centre - this.from) * factor, centre + (this.to - centre) * factor);
  }
  /// Keeps the cursor in sight.
  follow() {
    const { time } = this.cursor;
    const size = this.to - this.from;
    if (time > this.to) this.span(time - size * 0.1, time + size * 0.9);
    else if (time < this.from) this.span(time - size * 0.9, time + size * 0.1);
    this.place();
  }
  place() {
    const x = this.x(this.cursor.time);
    this.line.hidden = x < -0.5 || x > this.width + 0.5;
    this.line.style.transform = `translateX(${x.toFixed(1)}px)`;
  }
  /// Writes the values of the rows that can be seen.
  values(all) {
    const first = Math.floor(this.scroll.scrollTop / ROW);
    const last = Math.ceil((this.scroll.scrollTop + this.scroll.clientHeight) / ROW);
    const { instant } = this.cursor;
    for (let n = all ? 0 : first; n < (all ? this.rows.length : Math.min(last + 1, this.rows.length)); n++) {
      const row = this.rows[n];
      if (!row) continue;
      const i = row.signal.changes.index(instant);
      if (!all && row.shown === i) continue;
      row.shown = i;
      row.value.textContent = row.signal.shown(i);
      row.value.className = `value ${row.signal.changes.state(i)}`;
    }
  }
  select() {
    for (const row of this.rows) {
      if (!row) continue;
      const is = row.signal === this.cursor.selected;
      if (row.item.classList.contains("selected") !== is) {
        row.item.classList.toggle("selected", is);
        row.item.firstChild.setAttribute("aria-current", String(is));
      }
    }
    this.draw();
  }
  /// Opens the scope of a signal and scrolls to its row.
  reveal(signal) {
    if (this.closed.delete(signal.path)) this.build();
    const n = this.rows.findIndex((row) => row?.signal === signal);
    const top = n * ROW;
    const { scrollTop, clientHeight } = this.scroll;
    if (n >= 0 && (top < scrollTop || top + ROW > scrollTop + clientHeight)) {
      this.scroll.scrollTop = top - clientHeight / 2;
    }
  }
  /// The signal so many rows from the selected one.
  beside(by) {
    const signals = this.rows.filter(Boolean).map((row) => row.signal);
    const n = signals.indexOf(this.cursor.selected);
    const next = signals[Math.min(Math.max(n + by, 0), signals.length - 1)];
    if (next) {
      this.cursor.select(next);
      this.reveal(next);
    }
  }
  resize() {
    const names = this.list.getBoundingClientRect().width;
    this.width = Math.max(this.scroll.clientWidth - names, 40);
    this.height = this.scroll.clientHeight;
    this.line.style.left = `${names}px`;
    this.draw();
    this.values(false);
  }
  draw() {
    if (!this.width) return;
    this.palette ??= colours();
    const context = fit(this.canvas, this.width, this.height);
    context.clearRect(0, 0, this.width, this.height);
    this.grid(context);
    const top = this.scroll.scrollTop;
    const first = Math.max(0, Math.floor(top / ROW));
    for (let n = first; n < this.rows.length && n * ROW < top + this.height; n++) {
      const row = this.rows[n];
      const y = n * ROW - top;
      if (!row) {
        context.fillStyle = this.palette.fill;
        context.fillRect(0, y, this.width, ROW);
        continue;
      }
      if (row.signal === this.cursor.selected) {
        context.globalAlpha = 0.12;
        context.fillStyle = this.palette.accent;
        context.fillRect(0, y, this.width, ROW);
        context.globalAlpha = 1;
      }
      if (row.signal.analog && row.signal.kind !== "text") this.curve(context, row.signal, y);
      else this.row(context, row.signal, y);
    }
    this.place();
  }
  /// Lines at round times, and the times above.
  grid(context) {
    const per = (this.to - this.from) / this.width;
    const step = Math.max(nice(per * 90), 1);
    const ruler = fit(this.times, this.width, 22);
    ruler.clearRect(0, 0, this.width, 22);
    ruler.font = FONT;
    ruler.fillStyle = this.palette.soft;
    ruler.strokeStyle = context.strokeStyle = this.palette.grid;
    context.lineWidth = 1;
    context.beginPath();
    ruler.beginPath();
    for (let time = Math.ceil(this.from / step) * step; time <= this.to; time += step) {
      const x = Math.round(this.x(time)) + 0.5;
      context.moveTo(x, 0);
      context.lineTo(x, this.height);
      ruler.moveTo(x, 14);
      ruler.lineTo(x, 22);
      const text = this.trace.time(time, 9);
      const wide = text.length * 7.3;
      if (x + 3 + wide <= this.width) ruler.fillText(text, x + 3, 11);
    }
    context.stroke();
    ruler.stroke();
  }
  /// Goes through what a row shows: pieces of one value each, and columns in which more happens than can be told.
  pieces(signal, piece, quick) {
    const { changes } = signal;
    const { times } = this.trace;
    let x = 0;
    let i = changes.index(this.trace.instant(this.from));
    const stop = Math.min(this.width, this.x(this.trace.end));
    while (x < stop) {
      const next = i + 1 < changes.count ? this.x(times[changes.at[i + 1]]) : Infinity;
      if (next - x >= 1.5 || next >= stop) {
        piece(i, x, Math.min(next, stop), next <= stop);
        x = next;
        i++;
        continue;
      }
      const column = Math.floor(x) + 1;
      const j = changes.index(this.trace.instant(this.time(column)));
      quick(x, column, i, j);
      x = column;
      i = Math.max(j, i);
      // a change right at the end of the column begins the next piece
      if (i + 1 < changes.count && this.x(times[changes.at[i + 1]]) <= x) i++;
    }
  }
  row(context, signal, y) {
    const [top, bottom, middle] = [y + 5.5, y + ROW - 5.5, y + ROW / 2 + 0.5];
    const { changes, isBit } = signal;
    const known = new Path2D();
    const unknown = new Path2D();
    const floating = new Path2D();
    const high = new Path2D();
    const dense = new Path2D();
    const texts = [];
    let before = null;
    this.pieces(
      signal,
      (i, from, to) => {
        const state = changes.state(i);
        if (signal.kind === "event") {
          if (i >= 0) known.rect(from, top, 1, bottom - top);
        } else if (state === "floating") {
          floating.moveTo(from, middle);
          floating.lineTo(to, middle);
          if (!isBit && to - from > 12) texts.push([signal.shown(i), from, to, state]);
          before = null;
        } else if (isBit && state === "known") {
          const level = changes.level(i) ? top : bottom;
          if (before !== null && before !== level) {
            known.moveTo(from, before);
            known.lineTo(from, level);
          }
          known.moveTo(from, level);
          known.lineTo(to, level);
          if (level === top) high.rect(from, top, to - from, bottom - top);
          before = level;
        } else {
          const slope = Math.min(3, (to - from) / 2);
          const path = state === "unknown" ? unknown : known;
          path.moveTo(from, middle);
          path.lineTo(from + slope, top);
          path.lineTo(to - slope, top);
          path.lineTo(to, middle);
          path.lineTo(to - slope, bottom);
          path.lineTo(from + slope, bottom);
          path.closePath();
          if (to - from > 9) texts.push([signal.shown(i), from, to, state]);
          before = null;
        }
      },
      (from, to) => {
        dense.rect(from, top, Math.max(to - from, 0.5), bottom - top);
        before = null;
      },
    );
    const { palette } = this;
    context.lineWidth = 1.4;
    context.globalAlpha = 0.13;
    context.fillStyle = palette.high;
    context.fill(high);
    context.fillStyle = palette.unknown;
    context.fill(unknown);
    context.globalAlpha = 0.55;
    context.fillStyle = isBit ? palette.high : palette.accent;
    context.fill(dense);
    context.globalAlpha = 1;
    for (const [path, colour] of [[known, isBit ? palette.high : palette.accent], [unknown, palette.unknown], [floating, palette.floating]]) {
      context.strokeStyle = colour;
      context.stroke(path);
    }
    context.font = FONT;
    context.textBaseline = "middle";
    for (const [text, from, to, state] of texts) {
      const left = Math.max(from, 0) + 5;
      const room = Math.floor((Math.min(to, this.width) - left - 3) / 7.25);
      if (room < 1) continue;
      context.fillStyle = state === "known" ? palette.ink : palette[state];
      if (text.length <= room) context.fillText(text, left, middle);
      else if (room > 1) context.fillText(`${text.slice(0, room - 1)}…`, left, middle);
    }
  }
  /// The numbers of a signal as steps between their least and greatest.
  curve(context, signal, y) {
    const { changes } = signal;
    const signed = (signal.radix === "name" ? signal.plain : signal.radix) === "signed";
    if (signal.range?.signed !== signed) {
      let [least, greatest] = [Infinity, -Infinity];
      for (let i = 0; i < changes.count; i++) {
        const v = changes.value(i, signed);
        if (v < least) least = v;
        if (v > greatest) greatest = v;
      }
      signal.range = { signed, least, size: Math.max(greatest - least, 1) };
    }
    const { least, size } = signal.range;
    const level = (i) => y + ROW - 4 - ((changes.value(i, signed) - least) / size) * (ROW - 8);
    context.strokeStyle = this.palette.accent;
    context.lineWidth = 1.6;
    context.beginPath();
    let drawn = false;
    const to = (x, v) => {
      if (Number.isNaN(v)) drawn = false;
      else if (drawn) context.lineTo(x, v);
      else context.moveTo(x, v), (drawn = true);
    };
    this.pieces(
      signal,
      (i, from, until) => {
        to(from, level(i));
        to(until, level(i));
      },
      (from, until, i, j) => {
        // a column shows the least and the greatest of a sample of what is in it
        const step = Math.max(1, Math.floor((j - i) / 16));
        for (let k = i; k <= j; k += step) to(from, level(k));
      },
    );
    context.stroke();
  }
  handle() {
    const at = (event) => event.clientX - this.canvas.getBoundingClientRect().left;
    const scrub = (event) => {
      const time = Math.round(this.time(at(event)));
      this.cursor.seek(time);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.canvas.setPointerCapture(event.pointerId);
      const y = event.clientY - this.canvas.getBoundingClientRect().top + this.scroll.scrollTop;
      const row = this.rows[Math.floor(y / ROW)];
      if (row) this.cursor.select(row.signal);
      scrub(event);
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons & 1 && scrub(event));
    let held = null;
    this.times.addEventListener("pointerdown", (event) => {
      this.times.setPointerCapture(event.pointerId);
      held = [at(event), this.from, this.to];
    });
    this.times.addEventListener("pointermove", (event) => {
      if (!(event.buttons & 1) || !held) return;
      const by = ((held[0] - at(event)) / this.width) * (held[2] - held[1]);
      this.span(held[1] + by, held[2] + by);
    });
    const wheel = (event) => {
      const sideways = event.shiftKey ? event.deltaY : event.deltaX;
      if (event.ctrlKey || event.metaKey || event.currentTarget === this.times) {
        event.preventDefault();
        this.zoom(1.002 ** event.deltaY, this.time(at(event)));
      } else if (Math.abs(sideways) > Math.abs(event.shiftKey ? 0 : event.deltaY)) {
        event.preventDefault();
        const by = (sideways / this.width) * (this.to - this.from);
        this.span(this.from + by, this.to + by);
      }
    };
    for (const part of [this.canvas, this.times]) part.addEventListener("wheel", wheel, { passive: false });
    this.scroll.addEventListener("scroll", () => {
      this.draw();
      this.values(false);
    });
    this.section.querySelector(".zoom").addEventListener("click", (event) => {
      const what = event.target.closest("button")?.dataset.do;
      if (what === "in") this.zoom(0.5);
      else if (what === "out") this.zoom(2);
      else if (what === "fit") this.span(this.trace.start, this.trace.end);
    });
    new ResizeObserver(() => this.resize()).observe(this.scroll);
  }
}
