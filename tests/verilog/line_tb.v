// Checks line_rtl or line_gates (-DDUT=) on every clock against the recurrence of document B, for all (dx, dy) of W
// bits (-DWIDTH=, default 4), each twice on the running circuit from various start points, with two clocks after END.
// Prints PASS or what differs. +dx= and +dy= instead print that line's registers after each clock.
//
//   cd benches/verilog
//   iverilog -g2005 -DDUT=line_gates -o tb.vvp line_rtl.v line_gates.v ../../tests/verilog/line_tb.v && vvp -n tb.vvp
`timescale 1ns / 1ns
`ifndef DUT
`define DUT line_rtl
`endif
`ifndef WIDTH
`define WIDTH 4
`endif

module line_tb;
  localparam W = `WIDTH;
  reg start = 0, dt = 0;
  reg [W-1:0] dx = 0, dy = 0, xh = 0, yh = 0;
  wire x, y, done;
  wire [W-1:0] xt, yt;
  `DUT #(W) dut (
    .start(start), .dt(dt), .dx(dx), .dy(dy), .xh(xh), .yh(yh), .x(x), .y(y), .done(done), .xt(xt), .yt(yt));

  integer i, j, k, n, faults = 0, clocks = 0, edges_x = 0, edges_y = 0, ex, ey;
  integer f, kox, koy, cx, cy;
  reg want_x, want_y, table_;

  // A pulse too many, even of no length, would count here.
  always @(posedge x) edges_x = edges_x + 1;
  always @(posedge y) edges_y = edges_y + 1;

  task expect_state(input [8*8:1] when);
    if (xt !== cx[W-1:0] || yt !== cy[W-1:0] || dut.kox !== kox[W-1:0] || dut.koy !== koy[W-1:0]
        || dut.f !== f[W:0] || done !== (kox == 0 && koy == 0)) begin
      faults = faults + 1;
      if (faults < 10) $display("(%0d, %0d) clock %0d, %0s: xt=%0d yt=%0d kox=%0d koy=%0d f=%0d end=%b, not %0d %0d %0d %0d %0d %b",
        dx, dy, n, when, xt, yt, dut.kox, dut.koy, $signed(dut.f), done, cx, cy, kox, koy, f, kox == 0 && koy == 0);
    end
  endtask

  task clock;
    begin
      #5 ex = edges_x; ey = edges_y;
      dt = 1;
      #10 if (x !== want_x || y !== want_y || edges_x != ex + want_x || edges_y != ey + want_y) begin
        faults = faults + 1;
        if (faults < 10) $display("(%0d, %0d) clock %0d: x=%b y=%b, not %b %b", dx, dy, n, x, y, want_x, want_y);
      end
      dt = 0;
      #5 clocks = clocks + 1;
    end
  endtask

  task line;
    begin
      n = 0; f = 0; kox = dx; koy = dy; cx = xh; cy = yh;
      #2 start = 1;
      #3 expect_state("start=1");
      start = 0;
      #5 expect_state("start=0");
      if (table_) $display("clock x y   xt  yt kox koy    f end\n%5d - - %4d%4d%4d%4d%5d %b", 0, xt, yt, dut.kox, dut.koy, $signed(dut.f), done);
      while (kox != 0 || koy != 0) begin
        n = n + 1;
        want_x = f >= 0 && kox != 0;
        want_y = f < 0 && koy != 0;
        if (f >= 0) f = f - dy; else f = f + dx;
        if (want_x) begin kox = kox - 1; cx = cx + 1; end
        if (want_y) begin koy = koy - 1; cy = cy + 1; end
        clock;
        expect_state("dt=0");
        if (table_) $display("%5d %b %b %4d%4d%4d%4d%5d %b", n, want_x, want_y, xt, yt, dut.kox, dut.koy, $signed(dut.f), done);
      end
      if (!table_) begin
        want_x = 0; want_y = 0;
        clock; expect_state("after");
        clock; expect_state("after");
      end
    end
  endtask

  initial begin
    table_ = 0;
    if ($value$plusargs("dx=%d", dx) && $value$plusargs("dy=%d", dy)) begin
      table_ = 1;
      if (!$value$plusargs("xh=%d", xh)) xh = 0;
      if (!$value$plusargs("yh=%d", yh)) yh = 0;
      line;
    end else begin
      for (k = 0; k < 2; k = k + 1)
        for (i = 0; i < (1 << W); i = i + 1)
          for (j = 0; j < (1 << W); j = j + 1) begin
            dx = i; dy = j;
            xh = i * 5 + j * 3 + k; yh = i * 7 + j + k * 3;
            line;
          end
    end
    if (faults != 0) $display("FAIL: %0d faults in %0d clocks", faults, clocks);
    else if (!table_) $display("PASS: %0d clocks", clocks);
    $finish;
  end
endmodule
