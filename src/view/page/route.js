// The path over its ideal curve, with the point of the present time.

class Route {
  constructor(section, cursor, data) {
    this.section = section;
    this.cursor = cursor;
    this.data = data;
    if (!data) return;
    section.hidden = false;
    document.body.classList.add("with-route");
    this.canvas = section.querySelector("canvas");
    this.say = section.querySelector(".say");
    this.views = data.axes === 3 ? [[0, 1], [0, 2]] : [[0, 1]];
    this.still = document.createElement("canvas");
    cursor.watch((what) => what === "time" && this.draw());
    new ResizeObserver(() => this.resize()).observe(section);
  }
  /// The number of the point that is reached.
  get index() {
    return Math.max(countUpTo(this.data.times, this.cursor.time) - 1, 0);
  }
  /// How many clocks have begun, or steps been made.
  get number() {
    return this.data.clocks ? countUpTo(this.data.clocks, this.cursor.time) : this.index;
  }
  resize() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    this.width = box.width;
    this.height = box.height - 30;
    this.frames = this.views.map((view, n) => this.frame(view, n));
    this.paint();
    this.draw();
  }
  /// Where a view stands, at the same scale along both axes.
  frame(view, n) {
    const each = this.width / this.views.length;
    const [left, top, width, height] = [n * each + 34, 14, each - 52, this.height - 44];
    const ranges = view.map((axis) => {
      let [least, greatest] = [Infinity, -Infinity];
      for (const v of this.data.points[axis]) {
        if (v < least) least = v;
        if (v > greatest) greatest = v;
      }
      for (const p of this.data.ideal) {
        least = Math.min(least, p[axis]);
        greatest = Math.max(greatest, p[axis]);
      }
      const pad = (greatest - least) * 0.04 + 0.4;
      return [least - pad, greatest + pad];
    });
    const sizes = ranges.map(([a, b]) => b - a);
    const scale = Math.max(Math.min(width / sizes[0], height / sizes[1]), 1e-9);
    const x = (v) => left + (width - sizes[0] * scale) / 2 + (v - ranges[0][0]) * scale;
    const y = (v) => top + height - (height - sizes[1] * scale) / 2 - (v - ranges[1][0]) * scale;
    return { view, ranges, scale, x, y };
  }
  /// The line through points `from` to `to`, without those that nobody could tell apart.
  trail(context, frame, from, to) {
    const [xs, ys] = frame.view.map((axis) => this.data.points[axis]);
    let [px, py] = [frame.x(xs[from]), frame.y(ys[from])];
    context.beginPath();
    context.moveTo(px, py);
    for (let i = from + 1; i <= to; i++) {
      const [x, y] = [frame.x(xs[i]), frame.y(ys[i])];
      if (i < to && Math.abs(x - px) + Math.abs(y - py) < 0.7) continue;
      context.lineTo(x, y);
      [px, py] = [x, y];
    }
    context.stroke();
  }
  /// What does not move.
  paint() {
    if (!this.frames) return;
    const palette = (this.palette = colours());
    const context = fit(this.still, this.width, this.height);
    context.clearRect(0, 0, this.width, this.height);
    context.font = "11px system-ui, sans-serif";
    for (const frame of this.frames) {
      const { ranges, scale, x, y } = frame;
      const step = Math.max(nice(34 / scale), 1);
      const unit = scale >= 7 ? 1 : 0;
      const lines = (by, colour) => {
        context.strokeStyle = colour;
        context.lineWidth = 1;
        context.beginPath();
        for (let v = Math.ceil(ranges[0][0] / by) * by; v <= ranges[0][1]; v += by) {
          context.moveTo(Math.round(x(v)) + 0.5, y(ranges[1][0]));
          context.lineTo(Math.round(x(v)) + 0.5, y(ranges[1][1]));
        }
        for (let v = Math.ceil(ranges[1][0] / by) * by; v <= ranges[1][1]; v += by) {
          context.moveTo(x(ranges[0][0]), Math.round(y(v)) + 0.5);
          context.lineTo(x(ranges[0][1]), Math.round(y(v)) + 0.5);
        }
        context.stroke();
      };
      context.globalAlpha = 0.45;
      if (unit && step > 1) lines(unit, palette.grid);
      context.globalAlpha = 1;
      lines(step, palette.grid);
      context.fillStyle = palette.soft;
      context.textAlign = "center";
      context.textBaseline = "top";
      for (let v = Math.ceil(ranges[0][0] / step) * step; v <= ranges[0][1]; v += step) context.fillText(v, x(v), y(ranges[1][0]) + 4);
      context.textAlign = "right";
      context.textBaseline = "middle";
      for (let v = Math.ceil(ranges[1][0] / step) * step; v <= ranges[1][1]; v += step) context.fillText(v, x(ranges[0][0]) - 5, y(v));
      context.textAlign = "center";
      context.textBaseline = "bottom";
      context.fillText(`${"xyz"[frame.view[0]]}, BLU`, (x(ranges[0][0]) + x(ranges[0][1])) / 2, Math.min(y(ranges[1][0]) + 32, this.height));
      context.textAlign = "left";
      context.textBaseline = "top";
      context.fillText(`${"xyz"[frame.view[1]]}, BLU`, x(ranges[0][0]), Math.max(y(ranges[1][1]) - 14, 0));
      context.lineJoin = "round";
      if (this.data.ideal.length) {
        context.strokeStyle = palette.ideal;
        context.lineWidth = 2.2;
        context.beginPath();
        for (const p of this.data.ideal) context.lineTo(x(p[frame.view[0]]), y(p[frame.view[1]]));
        context.stroke();
      }
      context.strokeStyle = palette.accent;
      context.globalAlpha = 0.28;
      context.lineWidth = 1.6;
      this.trail(context, frame, 0, this.data.times.length - 1);
      context.globalAlpha = 1;
    }
  }

  // Says where the point is.
  tell() {
    const { index, data } = this;
    const names = ["x", "y", "z"].slice(0, data.axes);
    const at = names.map((name, axis) => `${name} = ${data.points[axis][index]}`).join(", ");
    const off = data.off.length ? `, ${(Math.abs(data.off[index]) / 1000).toFixed(2)} BLU off the ideal curve` : "";
    this.say.textContent = `${data.unit} ${this.number}: ${at}${off}`;
  }

  draw() {
    this.tell(); // also before the picture has its size
    if (!this.frames) return;
    const context = fit(this.canvas, this.width, this.height);
    context.clearRect(0, 0, this.width, this.height);
    context.drawImage(this.still, 0, 0, this.width, this.height);
    const { index, data, palette } = this;
    for (const frame of this.frames) {
      context.lineJoin = "round";
      context.strokeStyle = palette.accent;
      context.lineWidth = 2.2;
      this.trail(context, frame, 0, index);
      context.beginPath();
      context.arc(frame.x(data.points[frame.view[0]][index]), frame.y(data.points[frame.view[1]][index]), 6, 0, 7);
      context.fillStyle = palette.accent;
      context.strokeStyle = palette.paper;
      context.lineWidth = 2;
      context.fill();
      context.stroke();
    }
  }
}
