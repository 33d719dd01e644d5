// A test bench as engineers write them: data by nonblocking assignment at the clock edges, resets at any time, x and z
// among the data.
`timescale 1ns/100ps
module bench;
  reg clk_a = 0, clk_b = 0, rst_n, en = 0, strobe = 0, oe = 0;
  reg [7:0] d = 1, drive = 8'h3c;
  wire [7:0] bus, a, b;
  wire [3:0] strobes, gated;
  wire seen;
  assign bus = oe ? 8'bz : drive;
  replay dut (clk_a, clk_b, rst_n, en, strobe, d, oe, bus, a, b, strobes, seen, gated);
  always #5 clk_a = ~clk_a;
  always #7.5 clk_b = ~clk_b;
  always @(posedge clk_a) begin
    d <= $time > 900 ? d ^ 8'b0x0z0011 : d * 5 + 3;
    oe <= d[1] & rst_n;
    strobe <= d[2];
  end
  always @(negedge clk_a) en <= d[3];
  always @(negedge clk_b) drive <= drive + 7;
  initial begin
    $dumpfile("icarus.vcd");
    $dumpvars(0, bench);
    #12 rst_n = 0;
    @(posedge clk_a) rst_n <= 1;
    #300 rst_n = 0;
    #20 @(negedge clk_a) rst_n <= 1;
    #700 $finish;
  end
endmodule
