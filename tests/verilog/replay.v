// What makes a replay hard: two clocks whose edges meet, an asynchronous reset, a bus that both sides drive, a clock
// behind a gate, a strobe that is a clock and is sampled by another.
module replay (input clk_a, input clk_b, input rst_n, input en, input strobe, input [7:0] d, input oe, inout [7:0] bus,
               output reg [7:0] a, output reg [7:0] b, output reg [3:0] strobes, output reg seen, output reg [3:0] gated);
  wire [7:0] next = d + a;
  always @(posedge clk_a or negedge rst_n)
    if (!rst_n) a <= 0; else a <= next;
  always @(negedge clk_b or negedge rst_n)
    if (!rst_n) b <= 0; else b <= a ^ bus;
  always @(posedge strobe or negedge rst_n)
    if (!rst_n) strobes <= 0; else strobes <= strobes + d[3:0];
  always @(posedge clk_a) seen <= strobe;
  wire gclk = clk_a & en;
  always @(posedge gclk or negedge rst_n)
    if (!rst_n) gated <= 0; else gated <= gated + 1;
  assign bus = oe ? a : 8'bz;
endmodule
