// Lines one after another on circuits/evaluation/line.json: increments from an LFSR, a checksum of where it is. START is
// high for one clock, in which there is no pulse of dt; both change while the clock is low.
module shipped #(parameter W = 16) (
  input             clk,
  input             rst,
  output reg [31:0] checksum
);
  reg [31:0] lfsr;
  reg start;
  wire x, y, done;
  wire [W-1:0] xt, yt;
  reg [W-1:0] dx, dy, xh, yh;
  line circuit (
    .start(start), .dx(dx), .dy(dy), .xh(xh), .yh(yh), .dt(clk & ~start), .x(x), .y(y), .xt(xt), .yt(yt), .\end (done)
  );
  always @(negedge clk)
    if (rst) begin
      lfsr <= 32'h1;
      start <= 1;
      {dx, dy, xh, yh} <= 0;
    end else begin
      start <= done & ~start;
      if (done & ~start) begin
        lfsr <= {lfsr[30:0], 1'b0} ^ (lfsr[31] ? 32'h04c11db7 : 32'h0);
        dx <= lfsr[W-1:0];
        dy <= lfsr[2*W-1:W];
        xh <= xt;
        yh <= yt;
      end
    end
  always @(posedge clk)
    if (rst) checksum <= 0;
    else checksum <= {checksum[30:0], checksum[31]} ^ {xt, yt};
endmodule
