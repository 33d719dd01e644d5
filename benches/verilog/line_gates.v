// The line by evaluation function of gates and D flip-flops: circuits/evaluation/line_gates.json and the modules of
// circuits/lib gate by gate, under the same names (`many`, `bit` and `end` are spelt so that Verilog takes them).
`timescale 1ns / 1ns

// A D flip-flop clocked by the falling edge, with asynchronous set and reset, of which reset dominates.
module dff (input clk, d, set, reset, output reg q);
  always @(set or reset) if (reset) q <= 1'b0; else if (set) q <= 1'b1;
  always @(negedge clk) if (!set && !reset) q <= d;
endmodule

module half_adder_gates (input a, b, output s, co);
  wire any, not_both;
  or  or1 (any, a, b);
  and and1 (co, a, b);
  not not1 (not_both, co);
  and and2 (s, any, not_both);
endmodule

module full_adder_gates (input a, b, ci, output s, co);
  wire ab, generate_, propagate;
  half_adder_gates first (.a(a), .b(b), .s(ab), .co(generate_));
  half_adder_gates second (.a(ab), .b(ci), .s(s), .co(propagate));
  or or1 (co, generate_, propagate);
endmodule

module ripple_adder #(parameter W = 8) (input [W-1:0] a, b, input ci, output [W-1:0] y, output co);
  wire [W:0] c;
  buf carry_in (c[0], ci);
  genvar i;
  generate
    for (i = 0; i < W; i = i + 1) begin : stage
      full_adder_gates fa (.a(a[i]), .b(b[i]), .ci(c[i]), .s(y[i]), .co(c[i+1]));
    end
  endgenerate
  buf carry_out (co, c[W]);
endmodule

module negate #(parameter W = 8) (input [W-1:0] a, output [W-1:0] y);
  wire [W-1:0] low;
  buf low0 (low[0], a[0]);
  buf y0 (y[0], a[0]);
  genvar i;
  generate
    for (i = 1; i < W; i = i + 1) begin : stage
      wire both, not_both;
      or  or1 (low[i], a[i], low[i-1]);
      and and1 (both, a[i], low[i-1]);
      not not1 (not_both, both);
      and and2 (y[i], low[i], not_both);
    end
  endgenerate
endmodule

// One OR of all bits and a NOT; Verilog's primitives take no bus, hence the reduction.
module zero_detect #(parameter W = 8) (input [W-1:0] a, output y);
  wire any;
  assign any = |a;
  not not1 (y, any);
endmodule

module bus_mux #(parameter W = 8) (input [W-1:0] a, b, input sel_a, sel_b, output [W-1:0] y);
  genvar i;
  generate
    for (i = 0; i < W; i = i + 1) begin : stage
      wire a_gated, b_gated;
      and and1 (a_gated, a[i], sel_a);
      and and2 (b_gated, b[i], sel_b);
      or  or1 (y[i], a_gated, b_gated);
    end
  endgenerate
endmodule

module sr_nor (input s, r, output q, qn);
  nor nor1 (q, r, qn);
  nor nor2 (qn, s, q);
endmodule

module register_gates #(parameter W = 8) (
  input clk, input [W-1:0] d, input load, async_load, reset, output [W-1:0] q
);
  wire hold;
  not not1 (hold, load);
  genvar i;
  generate
    for (i = 0; i < W; i = i + 1) begin : stage
      wire new_, old, next, not_d, set, load_0, clear;
      and and1 (new_, d[i], load);
      and and2 (old, q[i], hold);
      or  or1 (next, new_, old);
      not not1 (not_d, d[i]);
      and and3 (set, async_load, d[i]);
      and and4 (load_0, async_load, not_d);
      or  or2 (clear, load_0, reset);
      dff ff (.clk(clk), .d(next), .set(set), .reset(clear), .q(q[i]));
    end
  endgenerate
endmodule

module counter_gates #(parameter W = 8, DOWN = 0) (
  input clk, en, input [W-1:0] d, input async_load, output [W-1:0] q, output zero
);
  wire [W:0] c;
  genvar i;
  generate
    if (DOWN) begin : first
      not down (c[0], en);
    end else begin : first
      buf up (c[0], en);
    end
    for (i = 0; i < W; i = i + 1) begin : stage
      wire next, not_d, set, clear;
      not not1 (not_d, d[i]);
      and and1 (set, async_load, d[i]);
      and and2 (clear, async_load, not_d);
      dff ff (.clk(clk), .d(next), .set(set), .reset(clear), .q(q[i]));
      if (DOWN) begin : down
        wire both, neither;
        or  or1 (c[i+1], q[i], c[i]);
        and and1 (both, q[i], c[i]);
        not not1 (neither, c[i+1]);
        or  or2 (next, both, neither);
      end else begin : up
        wire any, not_both;
        or  or1 (any, q[i], c[i]);
        and and1 (c[i+1], q[i], c[i]);
        not not1 (not_both, c[i+1]);
        and and2 (next, any, not_both);
      end
    end
  endgenerate
  zero_detect #(W) zero_detect_ (.a(q), .y(zero));
endmodule

module line_gates #(parameter W = 8) (
  input          start, dt,
  input  [W-1:0] dx, dy, xh, yh,
  output         x, y, done,
  output [W-1:0] xt, yt
);
  wire signed [W:0] f;
  wire [W:0] plus_dx, negated_dy, minus_dy, addend, sum;
  wire [W-1:0] kox, koy;
  wire not_sign, kox_zero, koy_zero, allow_x, allow_y, running;

  register_gates #(W+1) register1 (
    .clk(dt), .d({1'b0, dx}), .load(1'b0), .async_load(start), .reset(1'b0), .q(plus_dx));
  negate #(W+1) negative (.a({1'b0, dy}), .y(negated_dy));
  register_gates #(W+1) register2 (
    .clk(dt), .d(negated_dy), .load(1'b0), .async_load(start), .reset(1'b0), .q(minus_dy));
  bus_mux #(W+1) multiplexer (.a(plus_dx), .b(minus_dy), .sel_a(f[W]), .sel_b(not_sign), .y(addend));
  ripple_adder #(W+1) adder (.a(f), .b(addend), .ci(1'b0), .y(sum), .co());
  register_gates #(W+1) memory (
    .clk(dt), .d(sum), .load(running), .async_load(1'b0), .reset(start), .q(f));
  not not1 (not_sign, f[W]);
  and and3 (x, not_sign, allow_x, dt);
  and and4 (y, f[W], allow_y, dt);
  sr_nor trigger_x (.s(start), .r(kox_zero), .q(allow_x), .qn());
  sr_nor trigger_y (.s(start), .r(koy_zero), .q(allow_y), .qn());
  counter_gates #(W, 1) counter_kox (.clk(x), .en(1'b1), .d(dx), .async_load(start), .q(kox), .zero(kox_zero));
  counter_gates #(W, 1) counter_koy (.clk(y), .en(1'b1), .d(dy), .async_load(start), .q(koy), .zero(koy_zero));
  counter_gates #(W, 0) register3 (.clk(x), .en(1'b1), .d(xh), .async_load(start), .q(xt), .zero());
  counter_gates #(W, 0) register4 (.clk(y), .en(1'b1), .d(yh), .async_load(start), .q(yt), .zero());
  nor end_ (done, allow_x, allow_y);
  not not2 (running, done);
endmodule
