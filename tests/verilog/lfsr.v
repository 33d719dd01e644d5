// Shift registers with feedback, in both forms, of 16 bits (x^16 + x^14 + x^13 + x^11 + 1), and one of 4 bits with 0 in
// its cycle; `init` values and no reset.

module fibonacci #(parameter W = 16, parameter [W-1:0] TAPS = 16'hb400, parameter [W-1:0] SEED = 1) (
  input clk, input enable, output reg [W-1:0] state
);
  initial state = SEED;
  always @(posedge clk) if (enable) state <= {state[W-2:0], ^(state & TAPS)};
endmodule

module galois #(parameter W = 16, parameter [W-1:0] TAPS = 16'hb400, parameter [W-1:0] SEED = 1) (
  input clk, input enable, output reg [W-1:0] state
);
  initial state = SEED;
  always @(posedge clk) if (enable) state <= (state >> 1) ^ (TAPS & {W{state[0]}});
endmodule

module de_bruijn (input clk, input enable, output reg [3:0] state);
  initial state = 4'b0000;
  always @(posedge clk) if (enable) state <= {state[2:0], state[3] ^ state[2] ^ (state[2:0] == 0)};
endmodule

module lfsr (
  input clk, input [2:0] enable, output [15:0] one, output [15:0] two, output [3:0] three, output reg [7:0] ones,
  output reg [7:0] worst
);
  fibonacci #(.SEED(16'hace1)) left (.clk(clk), .enable(enable[0]), .state(one));
  galois #(.SEED(16'h0001)) right (.clk(clk), .enable(enable[1]), .state(two));
  de_bruijn third (.clk(clk), .enable(enable[2]), .state(three));
  // how many bits of the two differ, now and at most
  integer i;
  reg [7:0] differ;
  always @* begin
    differ = 0;
    for (i = 0; i < 16; i = i + 1) differ = differ + (one[i] ^ two[i]);
  end
  initial {ones, worst} = 0;
  always @(posedge clk) begin
    ones <= differ;
    if (differ > worst) worst <= differ;
  end
endmodule
