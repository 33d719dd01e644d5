// The one time that all parts show, and how it moves.

/// The times at which a clock of one bit rises.
const rising = (changes, i) => changes.level(i) === 1 && changes.level(i - 1) === 0;

class Cursor {
  constructor(trace) {
    this.trace = trace;
    this.time = trace.start;
    this.instant = trace.instant(trace.start);
    this.selected = null;
    this.playing = false;
    this.rate = 5;
    this.listeners = [];
  }
  /// Has a part told of every change: of the time, the selection, or how something is shown.
  watch(listener) {
    this.listeners.push(listener);
  }
  tell(what) {
    for (const listener of this.listeners) listener(what);
  }
  seek(time) {
    const { start, end } = this.trace;
    this.time = Math.min(Math.max(time, start), end);
    this.instant = this.trace.instant(this.time);
    this.tell("time");
  }
  /// To another instant; past the last one to the end.
  step(by) {
    const { times, start, end } = this.trace;
    const on = this.time > (times[this.instant] ?? start) && by < 0 ? this.instant + 1 : this.instant;
    const next = on + by;
    this.seek(next < 0 ? start : next >= times.length ? end : times[next]);
  }
  /// To the next change of a signal, or the one before, that is as wanted.
  jump(signal, by, wanted = () => true) {
    if (!signal) return;
    const { at } = signal.changes;
    let i = signal.changes.index(this.instant);
    // standing behind a change, the one before is that change itself
    if (by < 0 && i >= 0 && this.trace.times[at[i]] < this.time) i++;
    for (i += by; i >= 0 && i < at.length; i += by) {
      if (wanted(signal.changes, i)) return this.seek(this.trace.times[at[i]]);
    }
    this.seek(by < 0 ? this.trace.start : this.trace.end);
  }
  edge(by) {
    this.jump(this.trace.clock, by, rising);
  }
  select(signal) {
    this.selected = signal;
    this.tell("selection");
  }
  play(on) {
    if (on && this.time >= this.trace.end) this.seek(this.trace.start);
    this.playing = on;
    this.tell("playing");
    if (!on) return;
    let last = performance.now();
    let due = 0;
    const frame = (now) => {
      if (!this.playing) return;
      due += ((now - last) / 1000) * this.rate;
      last = now;
      const whole = Math.floor(due);
      if (whole > 0) {
        due -= whole;
        this.step(whole);
        if (this.time >= this.trace.end) return this.play(false);
      }
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }
}
