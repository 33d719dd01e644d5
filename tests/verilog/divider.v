// Signed division, a bit a clock (restoring), with the division of Verilog beside it.

module divide_unsigned #(parameter W = 8) (
  input clk, input rst, input start, input [W-1:0] n, input [W-1:0] d,
  output reg [W-1:0] quotient, output reg [W-1:0] remainder, output reg busy
);
  reg [W-1:0] divisor;
  reg [$clog2(W)-1:0] left;
  wire [W:0] shifted = {remainder, quotient[W-1]};
  wire [W:0] less = shifted - {1'b0, divisor};
  always @(posedge clk)
    if (rst) begin
      busy <= 0;
      left <= 0;
      {quotient, remainder, divisor} <= 0;
    end else if (start && !busy) begin
      busy <= 1;
      left <= W - 1;
      quotient <= n;
      remainder <= 0;
      divisor <= d;
    end else if (busy) begin
      remainder <= less[W] ? shifted[W-1:0] : less[W-1:0];
      quotient <= {quotient[W-2:0], ~less[W]};
      left <= left - 1;
      if (left == 0) busy <= 0;
    end
endmodule

module divider #(parameter W = 12) (
  input clk, input rst, input start, input signed [W-1:0] n, input signed [W-1:0] d,
  output signed [W-1:0] quotient, output signed [W-1:0] remainder, output busy, output reg by_zero, output right
);
  reg signed [W-1:0] dividend, divisor;
  wire [W-1:0] q, r;
  wire negative_n = dividend[W-1], negative = dividend[W-1] ^ divisor[W-1];
  divide_unsigned #(.W(W)) unit (
    .clk(clk), .rst(rst), .start(start), .n(n < 0 ? -n : n), .d(d < 0 ? -d : d), .quotient(q), .remainder(r), .busy(busy));
  assign quotient = negative ? -q : q;
  assign remainder = negative_n ? -r : r;
  assign right = busy | by_zero | quotient == dividend / divisor & remainder == dividend % divisor;
  always @(posedge clk)
    if (rst) begin
      dividend <= 0;
      divisor <= 1;
      by_zero <= 0;
    end else if (start & !busy) begin
      dividend <= n;
      divisor <= d;
      by_zero <= d == 0;
    end
endmodule
