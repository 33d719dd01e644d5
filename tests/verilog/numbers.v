// What the language offers for numbers: signs, widths that meet, parts of vectors, functions, generate loops and cases,
// a module that contains itself, ascending vectors, names that must be escaped.

// The largest of N signed numbers and its place.
module largest #(parameter N = 5, parameter W = 6, parameter FROM = 0) (
  input [N*W-1:0] in, output signed [W-1:0] value, output [3:0] place
);
  localparam LOW = N / 2, HIGH = N - LOW;
  generate
    if (N == 1) begin : leaf
      assign value = in;
      assign place = FROM;
    end else begin : branch
      wire signed [W-1:0] a, b;
      wire [3:0] at_a, at_b;
      largest #(.N(LOW), .W(W), .FROM(FROM)) low (.in(in[LOW*W-1:0]), .value(a), .place(at_a));
      largest #(.N(HIGH), .W(W), .FROM(FROM + LOW)) high (.in(in[N*W-1 -: HIGH*W]), .value(b), .place(at_b));
      assign {value, place} = a >= b ? {a, at_a} : {b, at_b};
    end
  endgenerate
endmodule

module multiply_add #(parameter A = 8, parameter B = 8, parameter Y = 12) (
  input signed [A-1:0] a, input signed [B-1:0] b, input signed [Y-1:0] c, output signed [Y-1:0] y
);
  assign y = a * b + c;
endmodule

// The sum of N products.
module dot #(parameter N = 3, parameter W = 5) (
  input [N*W-1:0] u, input [N*W-1:0] v, output signed [2*W+1:0] \sum.of.products
);
  localparam Y = 2 * W + 2;
  wire [(N+1)*Y-1:0] \partial= ;
  assign \partial= [Y-1:0] = 0;
  genvar i;
  generate
    for (i = 0; i < N; i = i + 1) begin : \term:i
      multiply_add #(.A(W), .B(W), .Y(Y)) \m[a] (
        .a(u[W*i +: W]), .b(v[W*i +: W]), .c(\partial= [Y*i +: Y]), .y(\partial= [Y*(i+1) +: Y]));
    end
  endgenerate
  assign \sum.of.products = \partial= [Y*N +: Y];
endmodule

module numbers (
  input clk, input rst, input signed [7:0] a, input signed [7:0] b, input [7:0] u, input [2:0] \at.place ,
  output reg signed [8:0] sum, output reg signed [15:0] product, output reg [7:0] mixed, output reg [7:0] shifts,
  output reg [15:0] written, output reg [0:7] ascending, output reg [3:0] flags, output reg [2:0] leading,
  output signed [5:0] most, output [3:0] \most@ , output signed [11:0] dotted, output reg [7:0] saturated, output reg [9:0] root
);
  function [7:0] reversed(input [7:0] from);
    integer i;
    for (i = 0; i < 8; i = i + 1) reversed[i] = from[7-i];
  endfunction

  function [2:0] leading_one(input [7:0] from);
    casez (from)
      8'b1???????: leading_one = 7;
      8'b01??????: leading_one = 6;
      8'b001?????: leading_one = 5;
      8'b0001????: leading_one = 4;
      8'b00001???: leading_one = 3;
      8'b000001??: leading_one = 2;
      8'b0000001?: leading_one = 1;
      default: leading_one = 0;
    endcase
  endfunction

  function signed [7:0] clamp(input signed [9:0] n);
    clamp = n > 127 ? 127 : n < -128 ? -128 : n;
  endfunction

  // by subtracting odd numbers, unrolled
  function [4:0] square_root(input [7:0] n);
    integer k;
    begin
      square_root = 0;
      for (k = 8; k > 0; k = k >> 1) if ((square_root + k) * (square_root + k) <= n) square_root = square_root + k;
    end
  endfunction

  largest #(.N(5)) \tree=5 (.in({a[5:0], b[7:2], u[6:1], a[7:2] ^ b[5:0], ~u[5:0]}), .value(most), .place(\most@ ));
  dot dot (.u({a, b[6:0]}), .v({u[7:1], b}), .\sum.of.products (dotted));

  wire signed [7:0] safe = b == 0 ? 8'sd1 : b;
  wire [0:7] up = {u[3:0], a[7:4]};
  wire [3:0] part = u[\at.place +: 4];  // may reach beyond the end: x
  always @(posedge clk)
    if (rst) begin
      {sum, product, mixed, shifts, flags, leading, saturated, root} <= 0;
      written <= 0;
      ascending <= 0;
    end else begin
      sum <= a + b;
      product <= a * b;
      mixed <= a / safe + u % safe - (a % safe);
      shifts <= (a >>> \at.place ) ^ $signed(u << \at.place [1:0]) ^ (b >> 2);
      written[2 * \at.place +: 2] <= a[\at.place -: 1] + u[1:0];
      ascending <= {up[4:7], up[0:3]} ^ reversed(u);
      ascending[\at.place ] <= ^part[0];
      flags <= {a < b, a < u, $signed(u) <= b, &a[7:6] | ~|b};
      leading <= leading_one(u);
      saturated <= clamp(a + b - $signed({1'b0, u[6:0]}));
      root <= square_root(u) * 10'd3 + {2{1'b1, &{3{u[0]}}}};
    end
endmodule
