// What the page shows: signals over time, unpacked from the data of the file. No part here knows of the document's looks.

/// The bytes that base64 text stands for.
const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

/// Reads numbers of seven bits a byte.
class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }
  get done() {
    return this.at >= this.bytes.length;
  }
  number() {
    let n = 0;
    let unit = 1;
    for (;;) {
      const byte = this.bytes[this.at++];
      n += (byte & 0x7f) * unit;
      if (byte < 0x80) return n;
      unit *= 128;
    }
  }
}

/// How many of a sorted list are not greater.
const countUpTo = (list, value) => {
  let lo = 0;
  let hi = list.length;
  while (lo < hi) {
    const mid = (lo + hi) >>> 1;
    if (list[mid] <= value) lo = mid + 1;
    else hi = mid;
  }
  return lo;
};

/// The changes of one thing: `at[i]` is the number of the instant of change i, `pos[i]` where its value is packed.
class Changes {
  constructor(text, kind, width) {
    const reader = new Reader(bytesOf(text));
    this.bytes = reader.bytes;
    this.kind = kind;
    this.width = width;
    this.octets = (width + 7) >> 3;
    const at = [];
    const pos = [];
    let instant = 0;
    while (!reader.done) {
      const head = reader.number();
      instant += Math.floor(head / 4);
      at.push(instant);
      if (kind === "bits" && width === 1) {
        pos.push(head % 4);
      } else if (kind === "bits") {
        // the sign of a position says whether a second plane follows
        pos.push(head % 4 === 1 ? -reader.at : reader.at);
        reader.at += this.octets * (1 + (head % 4));
      } else {
        const length = reader.number();
        pos.push(reader.at);
        reader.at += length;
      }
    }
    this.at = Uint32Array.from(at);
    this.pos = Int32Array.from(pos);
  }
  get count() {
    return this.at.length;
  }
  /// The number of the change that holds at an instant; -1 before the first.
  index(instant) {
    return countUpTo(this.at, instant) - 1;
  }
  /// One bit: 0, 1, 2 for x, 3 for z.
  level(i) {
    return i < 0 ? 2 : this.pos[i];
  }
  /// The bits of change i, the most significant first.
  bits(i) {
    if (this.width === 1) return "01xz"[this.level(i)];
    if (i < 0) return "x".repeat(this.width);
    const start = Math.abs(this.pos[i]);
    const has = this.pos[i] < 0;
    let text = "";
    for (let bit = this.width - 1; bit >= 0; bit--) {
      const value = (this.bytes[start + (bit >> 3)] >> (bit & 7)) & 1;
      const unknown = has && (this.bytes[start + this.octets + (bit >> 3)] >> (bit & 7)) & 1;
      text += unknown ? (value ? "z" : "x") : value;
    }
    return text;
  }
  /// What change i is: `known`, `unknown` or `floating`.
  state(i) {
    if (this.kind !== "bits") return "known";
    if (i < 0) return "unknown";
    if (this.width === 1) return ["known", "known", "unknown", "floating"][this.pos[i]];
    if (this.pos[i] >= 0) return "known";
    return this.bits(i).includes("x") ? "unknown" : "floating";
  }
  /// The number of change i, as a whole number up to 2^53 and beyond that nearly; none if a bit is not known.
  value(i, signed) {
    if (this.kind === "real") return Number(this.text(i));
    if (i < 0 || this.kind !== "bits") return NaN;
    if (this.width === 1) return this.pos[i] < 2 ? this.pos[i] : NaN;
    const start = this.pos[i];
    if (start < 0) return NaN;
    let n = 0;
    for (let octet = this.octets - 1; octet >= 0; octet--) n = n * 256 + this.bytes[start + octet];
    return signed && n >= 2 ** (this.width - 1) ? n - 2 ** this.width : n;
  }
  /// What is no bits, as it stands.
  text(i) {
    if (i < 0) return "";
    const end = i + 1 < this.count ? this.pos[i + 1] : this.bytes.length;
    const bytes = this.bytes.subarray(this.pos[i], end);
    // behind it may stand the head and length of the next, which are told by going through it again
    return new TextDecoder().decode(i + 1 < this.count ? bytes.subarray(0, this.length(i)) : bytes);
  }
  length(i) {
    let from = this.pos[i] - 1;
    while (from > 0 && this.bytes[from - 1] >= 0x80) from--;
    const reader = new Reader(this.bytes);
    reader.at = from;
    return reader.number();
  }
}

/// The ways to write numbers, in the order in which they are offered; `name` where values have names.
const RADICES = ["decimal", "signed", "hexadecimal", "binary"];

/// Bits as hexadecimal digits, x or z where all four are; where only some are, the bits themselves.
const hexadecimal = (bits) => {
  const padded = bits.padStart(Math.ceil(bits.length / 4) * 4, /[xz]/.test(bits[0]) ? bits[0] : "0");
  let text = "";
  for (let i = 0; i < padded.length; i += 4) {
    const digit = padded.slice(i, i + 4);
    if (/^[01]+$/.test(digit)) text += parseInt(digit, 2).toString(16);
    else if (/^x+$|^z+$/.test(digit)) text += digit[0];
    else return bits;
  }
  return text;
};

/// Bits as a number in some radix.
const written = (bits, radix) => {
  if (bits.length === 1 || radix === "binary") return bits;
  if (/^x+$|^z+$/.test(bits)) return bits[0];
  if (radix === "hexadecimal" || /[xz]/.test(bits)) return bits.length > 8 || !/[xz]/.test(bits) ? hexadecimal(bits) : bits;
  const n = BigInt("0b" + bits);
  return String(radix === "signed" ? BigInt.asIntN(bits.length, n) : n);
};

/// A signal by one of its names.
class Signal {
  constructor(about, changes) {
    Object.assign(this, { signed: false, port: "", clock: false, hidden: false, values: null }, about);
    this.changes = changes;
    this.path = this.name.slice(0, this.scope);
    this.own = this.name.slice(this.scope ? this.scope + 1 : 0);
    this.plain = this.signed ? "signed" : this.width > 16 ? "hexadecimal" : "decimal";
    this.radix = this.values ? "name" : this.plain;
    this.analog = false;
    this.memory = [-2, ""];
  }
  get isBit() {
    return this.kind === "bits" && this.width === 1;
  }
  /// What change i is, as text; the one that was asked for last is kept.
  shown(i) {
    if (this.memory[0] !== i) {
      const text = this.kind === "bits" ? this.written(this.changes.bits(i)) : this.changes.text(i);
      this.memory = [i, text];
    }
    return this.memory[1];
  }
  at(instant) {
    return this.shown(this.changes.index(instant));
  }
  /// Bits by their name, or as a number where they have none.
  written(bits) {
    if (this.radix !== "name") return written(bits, this.radix);
    return this.values[bits] ?? written(bits, this.plain);
  }
  nextRadix() {
    const all = this.width < 2 ? ["name", "binary"] : this.values ? ["name", ...RADICES] : RADICES;
    this.radix = all[(all.indexOf(this.radix) + 1) % all.length];
    this.memory = [-2, ""];
  }
}

/// All of them, and the instants at which anything changes.
class Trace {
  constructor(data) {
    const reader = new Reader(bytesOf(data.times));
    const times = [];
    for (let now = 0; !reader.done; ) times.push((now += reader.number()));
    this.times = Float64Array.from(times);
    this.start = data.start;
    this.end = data.end;
    this.tick = data.tick;
    const kinds = [];
    for (const about of data.signals) kinds[about.of] ??= about;
    const changes = data.changes.map((text, i) => new Changes(text, kinds[i].kind, kinds[i].width));
    this.signals = data.signals.map((about) => new Signal(about, changes[about.of]));
    this.names = new Map(this.signals.map((signal) => [signal.name, signal]));
    this.clock = this.signals.find((signal) => signal.clock);
  }
  /// The number of the last instant that is not after a time; -1 before the first.
  instant(time) {
    return countUpTo(this.times, time) - 1;
  }
  /// A time with its unit, the greatest in which it is short.
  time(ticks, digits = 6) {
    if (!this.tick) return `tick ${ticks}`;
    const units = ["fs", "ps", "ns", "us", "ms", "s"];
    let unit = units.indexOf(this.tick[1]);
    let number = ticks * this.tick[0];
    while (number >= 10000 && unit < units.length - 1) {
      number /= 1000;
      unit++;
    }
    return `${Number(number.toPrecision(digits))} ${units[unit]}`;
  }
}
