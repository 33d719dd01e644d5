"""An Amaranth design on discreta and on Amaranth's own simulator: the same on every clock, and timed."""

import time

import discreta
import pytest

pytest.importorskip("amaranth")
from amaranth.hdl import Array, Elaboratable, Module, Signal  # noqa: E402
from amaranth.sim import Simulator  # noqa: E402
from amaranth.back import rtlil  # noqa: E402


class Mixer(Elaboratable):
    """A shift register with feedback that adds what it comes by to sums, one of four at a time."""

    def __init__(self):
        self.load = Signal(16)
        self.start = Signal()
        self.state = Signal(16)
        self.total = Signal(24)

    def elaborate(self, platform):
        m = Module()
        sums = Array(Signal(24, name=f"sum{i}") for i in range(4))
        feedback = self.state[15] ^ self.state[13] ^ self.state[12] ^ self.state[10]
        which = self.state[:2]
        with m.If(self.start):
            m.d.sync += self.state.eq(self.load)
        with m.Else():
            m.d.sync += self.state.eq((self.state << 1) | feedback)
            m.d.sync += sums[which].eq(sums[which] + self.state)
        m.d.comb += self.total.eq(sums[0] + (sums[1] ^ sums[2]) - sums[3])
        return m


def on_amaranth(clocks):
    dut = Mixer()
    found = []

    async def bench(ctx):
        ctx.set(dut.load, 0xACE1)
        ctx.set(dut.start, 1)
        await ctx.tick()
        ctx.set(dut.start, 0)
        for _ in range(clocks):
            await ctx.tick()
            found.append((ctx.get(dut.state), ctx.get(dut.total)))

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(bench)
    sim.run()
    return found


def on_discreta(circuit, clocks, engine):
    sim = discreta.Simulator(circuit, engine)
    sim.poke(clk=0, rst=0, load=0xACE1, start=1)
    sim.settle()
    sim.tick("clk")
    sim.nets.start = 0
    found = []
    for _ in range(clocks):
        sim.tick("clk")
        found.append((int(sim["state"]), int(sim["total"])))
    return found


def to_circuit(dut):
    """The netlist of an Amaranth design, through its RTLIL and Yosys."""
    text = rtlil.convert(dut, ports=[dut.load, dut.start, dut.state, dut.total])
    return discreta.load_rtlil(text)


@pytest.mark.parametrize("engine", ["auto", "event", "compiled"])
def test_both_have_the_same_on_every_clock(engine):
    clocks = 500
    circuit = to_circuit(Mixer())
    begun = time.perf_counter()
    ours = on_discreta(circuit, clocks, engine)
    middle = time.perf_counter()
    theirs = on_amaranth(clocks)
    ended = time.perf_counter()
    print(f"{clocks} clocks: discreta {middle - begun:.3f} s, Amaranth {ended - middle:.3f} s")
    assert len(set(ours)) > clocks // 2
    assert ours == theirs
