// Lines by evaluation function, one after another: increments from an LFSR, one step a clock, a checksum of where it is.
module line #(parameter W = 16) (
  input             clk,
  input             rst,
  output reg [31:0] checksum
);
  reg        [31:0]  lfsr;
  reg        [W-1:0] dx, dy, kox, koy, xt, yt;
  reg signed [W:0]   f;

  wire allow_x = kox != 0;
  wire allow_y = koy != 0;
  wire done = ~(allow_x | allow_y);
  wire sign = f[W];
  wire x = ~sign & allow_x;
  wire y = sign & allow_y;
  wire [W:0] addend = sign ? {1'b0, dx} : -{1'b0, dy};

  always @(posedge clk)
    if (rst) begin
      lfsr <= 32'h1;
      {dx, dy, kox, koy, xt, yt} <= 0;
      f <= 0;
      checksum <= 0;
    end else begin
      checksum <= {checksum[30:0], checksum[31]} ^ {xt, yt};
      if (done) begin
        lfsr <= {lfsr[30:0], 1'b0} ^ (lfsr[31] ? 32'h04c11db7 : 32'h0);
        dx <= lfsr[W-1:0];
        dy <= lfsr[2*W-1:W];
        kox <= lfsr[W-1:0];
        koy <= lfsr[2*W-1:W];
        f <= 0;
      end else begin
        f <= f + addend;
        if (x) begin
          kox <= kox - 1'b1;
          xt <= xt + 1'b1;
        end
        if (y) begin
          koy <= koy - 1'b1;
          yt <= yt + 1'b1;
        end
      end
    end
endmodule
