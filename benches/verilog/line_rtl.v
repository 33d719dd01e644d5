// The line by evaluation function at register level: circuits/evaluation/line.json cell by cell, under the same names.
// Loads are level-sensitive while start is 1, as async_load is.
`timescale 1ns / 1ns

module line_rtl #(parameter W = 8) (
  input          start, dt,
  input  [W-1:0] dx, dy, xh, yh,
  output         x, y, done,
  output [W-1:0] xt, yt
);
  reg signed  [W:0] plus_dx, minus_dy, f;
  reg         [W-1:0] kox, koy, register3, register4;
  reg                 allow_x, allow_y;

  // register1, register2
  always @(start or dx) if (start) plus_dx <= {1'b0, dx};
  wire [W:0] negated_dy = 0 - {1'b0, dy};
  always @(start or negated_dy) if (start) minus_dy <= negated_dy;

  // and1, and2, or1: the bus multiplexer
  wire not_sign = ~f[W];
  wire [W:0] dx_gated = {(W+1){f[W]}} & plus_dx;
  wire [W:0] dy_gated = {(W+1){not_sign}} & minus_dy;
  wire [W:0] addend = dx_gated | dy_gated;

  // adder, memory
  wire [W:0] sum = f + addend;
  wire running = ~done;
  always @(negedge dt or posedge start)
    if (start) f <= 0;
    else if (running) f <= sum;

  // and3, and4
  assign x = not_sign & allow_x & dt;
  assign y = f[W] & allow_y & dt;

  // trigger_x, trigger_y: reset dominates
  wire kox_zero = kox == 0;
  wire koy_zero = koy == 0;
  always @(start or kox_zero) if (kox_zero) allow_x <= 0; else if (start) allow_x <= 1;
  always @(start or koy_zero) if (koy_zero) allow_y <= 0; else if (start) allow_y <= 1;
  assign done = ~(allow_x | allow_y);

  // kox, koy
  always @(start or dx) if (start) kox <= dx;
  always @(negedge x) if (!start) kox <= kox - 1'b1;
  always @(start or dy) if (start) koy <= dy;
  always @(negedge y) if (!start) koy <= koy - 1'b1;

  // register3, register4
  always @(start or xh) if (start) register3 <= xh;
  always @(negedge x) if (!start) register3 <= register3 + 1'b1;
  always @(start or yh) if (start) register4 <= yh;
  always @(negedge y) if (!start) register4 <= register4 + 1'b1;
  assign xt = register3;
  assign yt = register4;
endmodule
