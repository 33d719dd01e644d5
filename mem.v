module mem(input clk, input [2:0] a, input [7:0] d, input we, output [7:0] q);
  reg [7:0] ram [0:7];
  always @(posedge clk) if (we) ram[a] <= d;
  assign q = ram[a];
endmodule
