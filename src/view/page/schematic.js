// The drawing with the values on its wires. What the drawing promises stands in the documentation of the room `draw`.

/// The bits that a wire carries, cut from those of the signal, the most significant first.
const sliced = (bits, range) => {
  if (!range) return bits;
  const [hi, lo = hi] = range.split(":").map(Number);
  return bits.slice(bits.length - 1 - hi, bits.length - lo);
};

class Schematic {
  constructor(section, cursor) {
    this.cursor = cursor;
    this.section = section;
    this.svg = section.querySelector("svg.schematic");
    this.wires = [];
    if (!this.svg) return;
    const top = this.svg.dataset.top ?? "";
    for (const group of this.svg.querySelectorAll("g.net")) {
      const name = group.dataset.net;
      const signal = name && cursor.trace.names.get(top ? `${top}.${name}` : name);
      if (!signal || signal.kind !== "bits") {
        // nothing may pass for 0
        group.classList.add("vnone");
        const title = group.querySelector(":scope > title");
        if (title) title.textContent += ": not recorded";
        continue;
      }
      const whole = `${signal.width - 1}:0`;
      const range = group.dataset.bits === whole || signal.width === 1 ? "" : group.dataset.bits ?? "";
      const title = document.createElementNS("http://www.w3.org/2000/svg", "title");
      group.prepend(title);
      const labels = [...group.querySelectorAll("text.value")];
      this.wires.push({ group, signal, range, title, labels, shown: -2, changed: false });
      group.addEventListener("click", () => cursor.select(signal));
    }
    this.pan();
    section.querySelector(".zoom").addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button) this.zoom(button.dataset.do);
    });
    cursor.watch((what) => (what === "selection" ? this.mark() : this.draw(what === "radix")));
  }
  /// Writes the values of the present instant; only what has changed is touched.
  draw(all) {
    const { instant } = this.cursor;
    for (const wire of this.wires) {
      const { changes } = wire.signal;
      const i = changes.index(instant);
      const changed = i > 0 && changes.at[i] === instant;
      if (!all && wire.shown === i && wire.changed === changed) continue;
      const bits = sliced(changes.bits(i), wire.range);
      const state = /x/.test(bits) ? "vx" : /z/.test(bits) ? "vz" : bits.length > 1 ? "vbus" : bits === "1" ? "v1" : "v0";
      const text = wire.range ? written(bits, bits.length > 16 ? "hexadecimal" : "decimal") : wire.signal.shown(i);
      const { classList } = wire.group;
      if (wire.state !== state) {
        if (wire.state) classList.remove(wire.state);
        classList.add(state);
      }
      if (wire.changed !== changed) classList.toggle("changed", changed);
      for (const label of wire.labels) label.textContent = text;
      wire.title.textContent = `${wire.group.dataset.net}${wire.range ? `[${wire.range}]` : ""} = ${text}`;
      Object.assign(wire, { shown: i, changed, state, text });
    }
  }
  mark() {
    for (const { group, signal } of this.wires) group.classList.toggle("selected", signal === this.cursor.selected);
  }
  /// Drag, wheel and two fingers move the part that is seen.
  pan() {
    const stage = this.section.querySelector(".stage");
    const box = this.svg.viewBox.baseVal;
    const whole = [box.x, box.y, box.width, box.height];
    let moved = 0;
    this.whole = whole;
    this.seen = whole.slice();
    this.svg.removeAttribute("width");
    this.svg.removeAttribute("height");
    // where all of it would be too small to be read, it begins at its top left corner
    const begin = new ResizeObserver(() => {
      const { width, height } = stage.getBoundingClientRect();
      const least = 0.55;
      if (!width || moved || this.seen.some((v, n) => v !== whole[n])) return begin.disconnect();
      if (innerWidth <= 760 && Math.min(width / whole[2], height / whole[3]) < least) {
        this.show([whole[0], whole[1], width / least, height / least]);
        begin.disconnect();
      }
    });
    begin.observe(stage);
    const scale = () => {
      const { width, height } = stage.getBoundingClientRect();
      return Math.max(this.seen[2] / width, this.seen[3] / height);
    };
    const pointers = new Map();
    stage.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      moved = 0;
    });
    stage.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const now = [event.clientX, event.clientY];
      const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      moved += Math.abs(now[0] - before[0]) + Math.abs(now[1] - before[1]);
      if (moved > 4) stage.setPointerCapture?.(event.pointerId);
      if (others.length) {
        const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
        this.around(apart(before, others[0]) / apart(now, others[0]), now[0], now[1]);
      } else {
        const s = scale();
        this.show([this.seen[0] - (now[0] - before[0]) * s, this.seen[1] - (now[1] - before[1]) * s, this.seen[2], this.seen[3]]);
      }
      pointers.set(event.pointerId, now);
    });
    for (const end of ["pointerup", "pointercancel", "pointerleave"]) {
      stage.addEventListener(end, (event) => pointers.delete(event.pointerId));
    }
    // a drag is no click
    stage.addEventListener("click", (event) => moved > 4 && event.stopPropagation(), true);
    stage.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.around(1.0015 ** event.deltaY, event.clientX, event.clientY);
    }, { passive: false });
  }
  around(factor, x, y) {
    const { left, top, width, height } = this.section.querySelector(".stage").getBoundingClientRect();
    const s = Math.max(this.seen[2] / width, this.seen[3] / height);
    const size = Math.min(Math.max(factor, 40 / this.seen[2]), (4 * this.whole[2]) / this.seen[2]);
    const at = [this.seen[0] + this.seen[2] / 2 + (x - left - width / 2) * s, this.seen[1] + this.seen[3] / 2 + (y - top - height / 2) * s];
    this.show([at[0] + (this.seen[0] - at[0]) * size, at[1] + (this.seen[1] - at[1]) * size, this.seen[2] * size, this.seen[3] * size]);
  }
  show(box) {
    this.seen = box;
    this.svg.setAttribute("viewBox", box.map((v) => v.toFixed(2)).join(" "));
  }
  zoom(what) {
    if (!this.svg) return;
    if (what === "fit") return this.show(this.whole.slice());
    const { left, top, width, height } = this.section.querySelector(".stage").getBoundingClientRect();
    this.around(what === "in" ? 0.7 : 1 / 0.7, left + width / 2, top + height / 2);
  }
}
