// Makes counter.vcd: iverilog -g2012 -o counter.vvp counter.v && vvp counter.vvp
`timescale 1ns / 1ns
module counter (input clk, input reset, output reg [7:0] q, output [3:0] t);
  assign t = q[0] ? 4'bz01x : q[3:0];
  always @(posedge clk or posedge reset) q <= reset ? 8'd0 : q + 8'd3;
endmodule

module top;
  reg clk = 0, reset;
  wire [7:0] q;
  wire [3:0] t;
  counter dut (.clk(clk), .reset(reset), .q(q), .t(t));
  always #5 clk = !clk;
  initial begin
    $dumpfile("counter.vcd");
    $dumpvars(0, top);
    #3 reset = 1;
    #9 reset = 0;
    #100 $finish;
  end
endmodule
