// Latches: transparent, with clear, addressed, a flip-flop of two of them, an SR latch of gates, a register of latches
// in two phases.

module latch #(parameter W = 1) (input open, input [W-1:0] d, output reg [W-1:0] q);
  always @* if (open) q = d;
endmodule

module latch_with_clear #(parameter W = 4) (input open, input clear_n, input [W-1:0] d, output reg [W-1:0] q);
  always @*
    if (!clear_n) q = 0;
    else if (open) q = d;
endmodule

module master_slave (input clk, input d, output q);
  wire between;
  latch master (.open(~clk), .d(d), .q(between));
  latch slave (.open(clk), .d(between), .q(q));
endmodule

module nor_latch (input set, input reset, output q, output q_n);
  nor upper (q, reset, q_n);
  nor lower (q_n, set, q);
endmodule

module latches (
  input phase1, input phase2, input clear_n, input [3:0] data, input [1:0] address, input write, input set, input reset,
  output [3:0] held, output [3:0] cleared, output [15:0] addressed, output flip_flop, output q, output q_n,
  output [3:0] shifted, output reg [3:0] chosen
);
  latch #(4) plain (.open(write), .d(data), .q(held));
  latch_with_clear #(4) clears (.open(write & address[0]), .clear_n(clear_n), .d(~data), .q(cleared));
  genvar i;
  generate
    for (i = 0; i < 4; i = i + 1) begin : place
      latch #(4) each (.open(write & address == i), .d(data), .q(addressed[4*i +: 4]));
    end
    for (i = 0; i < 4; i = i + 1) begin : stage
      wire in, between;
      if (i == 0) assign in = ^data;
      else assign in = shifted[i-1];
      latch one (.open(phase1), .d(in), .q(between));
      latch two (.open(phase2), .d(between), .q(shifted[i]));
    end
  endgenerate
  master_slave both (.clk(phase1), .d(data[3]), .q(flip_flop));
  nor_latch gates (.set(set), .reset(reset), .q(q), .q_n(q_n));
  // not every value of `address` says what it is: a latch
  always @*
    case (address)
      2'd0: chosen = held;
      2'd1: chosen = cleared;
      2'd2: if (q) chosen = data;
    endcase
endmodule
