// Names that are hard to carry, hierarchy, a bus with two drivers, an asynchronous reset, a negative edge, signed
// arithmetic, a latch.
module counter #(parameter W = 4) (input clk, input rst_n, input en, output reg [W-1:0] q);
  always @(posedge clk or negedge rst_n)
    if (!rst_n) q <= 0;
    else if (en) q <= q + 1;
endmodule

module stage (input clk, input signed [7:0] d, input open, (* keep *) output signed [7:0] y, output reg [7:0] held);
  reg signed [7:0] \r.0 ;
  always @(negedge clk) \r.0 <= d;
  assign y = \r.0 - (\r.0 >>> 1);
  always @* if (open) held = d ^ y;
endmodule

module names (input clk, input rst_n, input [7:0] \in.data , input [1:0] sel, output [7:0] \out=1 , output [7:0] held, inout [3:0] bus);
  wire [3:0] count, slow;
  (* keep *) wire signed [7:0] y;
  wire [7:4] upper = held[7:4];
  counter #(4) fast (.clk(clk), .rst_n(rst_n), .en(1'b1), .q(count));
  counter #(4) \slow.one (.clk(clk), .rst_n(rst_n), .en(count[1] & sel[0]), .q(slow));
  stage s0 (.clk(clk), .d(\in.data ), .open(sel[1]), .y(y), .held(held));
  assign \out=1 = sel[0] ? y * $signed({1'b0, count}) : {upper, slow};
  assign bus = sel == 2'd1 ? count : 4'bz;
  assign bus = sel == 2'd2 ? slow : 4'bz;
endmodule
