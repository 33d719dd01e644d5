// Lines back to back for +clocks=N clocks, and a checksum of all that they did.
//
//   iverilog -g2005 -DDUT=line_rtl -o rtl.vvp line_rtl.v line_gates.v bench.v && vvp -n rtl.vvp +clocks=1000000
//
// Before each clock, if the last line has ended (or there is none yet), a new one starts where it ended, with
//   seed = seed * 1664525 + 1013904223 (32 bits, from 1),  dx = seed[31:24],  dy = seed[23:16]
// and sum = rotl(sum, 1) ^ {xt, yt} as START leaves them. At each clock sum = rotl(sum, 1) ^ {x, y} while dt is 1. The
// first line starts at (0, 0). A line (0, 0) still takes one clock, without a step.
`timescale 1ns / 1ns
`ifndef DUT
`define DUT line_rtl
`endif

module bench;
  localparam W = 8;
  reg start = 0, dt = 0;
  reg [W-1:0] dx = 0, dy = 0, xh = 0, yh = 0;
  wire x, y, done;
  wire [W-1:0] xt, yt;
  `DUT #(W) dut (
    .start(start), .dt(dt), .dx(dx), .dy(dy), .xh(xh), .yh(yh), .x(x), .y(y), .done(done), .xt(xt), .yt(yt));

  integer clocks, clock, lines = 0;
  reg [31:0] seed = 1, sum = 0;

  initial begin
    if (!$value$plusargs("clocks=%d", clocks)) clocks = 1000000;
    for (clock = 0; clock < clocks; clock = clock + 1) begin
      #10 if (done !== 0) begin // x before the first START
        seed = seed * 1664525 + 1013904223;
        dx = seed[31:24];
        dy = seed[23:16];
        if (lines != 0) begin xh = xt; yh = yt; end
        lines = lines + 1;
        start = 1;
        #2 start = 0;
        sum = {sum[30:0], sum[31]} ^ {xt, yt};
        #8;
      end
      dt = 1;
      #10 sum = {sum[30:0], sum[31]} ^ {x, y};
      dt = 0;
    end
    #5 $display("clocks=%0d lines=%0d sum=%08x xt=%0d yt=%0d", clocks, lines, sum, xt, yt);
    $finish;
  end
endmodule
