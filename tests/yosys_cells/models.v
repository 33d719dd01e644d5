// Models of cells for which the simulation library that is installed (Yosys 0.23 and on) has none, or none that can be
// compared. Each says why it is here, and where its meaning comes from.

// New in Yosys 0.36: a buffer that is a wire.
module own_buf (A, Y);
  parameter A_SIGNED = 0; parameter A_WIDTH = 1; parameter Y_WIDTH = 1;
  input [A_WIDTH-1:0] A; output [Y_WIDTH-1:0] Y;
  generate if (A_SIGNED) assign Y = $signed(A); else assign Y = A; endgenerate
endmodule

// Until 0.33 the library took an unknown select line for an inactive one; since then x on a line gives x, as
// Yosys' own evaluation has always had it (and that takes z alike).
module own_pmux (A, B, S, Y);
  parameter WIDTH = 1; parameter S_WIDTH = 1;
  input [WIDTH-1:0] A; input [WIDTH*S_WIDTH-1:0] B; input [S_WIDTH-1:0] S; output reg [WIDTH-1:0] Y;
  integer i, n;
  always @* begin
    Y = A; n = 0;
    for (i = 0; i < S_WIDTH; i = i + 1) if (S[i] === 1'b1) begin Y = B[i*WIDTH +: WIDTH]; n = n + 1; end
    if (n > 1 || ^S === 1'bx) Y = {WIDTH{1'bx}};
  end
endmodule

// Where the condition is unknown and both values are z, Icarus' conditional operator gives z and IEEE 1364-2005, table
// 5-21, x. So the table is written out, for all cells whose model is that operator.
module choice (input a, input b, input s, output y);
  assign y = s === 1'b0 ? a : s === 1'b1 ? b : (a === b && a !== 1'bz) ? a : 1'bx;
endmodule
module own_mux (A, B, S, Y);
  parameter WIDTH = 1;
  input [WIDTH-1:0] A, B; input S; output [WIDTH-1:0] Y;
  choice bits [WIDTH-1:0] (A, B, {WIDTH{S}}, Y);
endmodule
module own_tribuf (A, EN, Y);
  parameter WIDTH = 1;
  input [WIDTH-1:0] A; input EN; output [WIDTH-1:0] Y;
  choice bits [WIDTH-1:0] ({WIDTH{1'bz}}, A, {WIDTH{EN}}, Y);
endmodule
module own__TBUF_ (A, E, Y);
  input A, E; output Y;
  choice bits (1'bz, A, E, Y);
endmodule
module own__MUX_ (A, B, S, Y);
  input A, B, S; output Y;
  choice bits (A, B, S, Y);
endmodule
// The library's model of $bmux also gives one bit where S_WIDTH is 1 and WIDTH is more.
module own_bmux (A, S, Y);
  parameter WIDTH = 1; parameter S_WIDTH = 1;
  input [(WIDTH << S_WIDTH)-1:0] A; input [S_WIDTH-1:0] S; output [WIDTH-1:0] Y;
  wire [WIDTH-1:0] low, high;
  generate if (S_WIDTH > 1) begin : more
    own_bmux #(.WIDTH(WIDTH), .S_WIDTH(S_WIDTH-1)) l (.A(A[(WIDTH << (S_WIDTH-1))-1:0]), .S(S[S_WIDTH-2:0]), .Y(low));
    own_bmux #(.WIDTH(WIDTH), .S_WIDTH(S_WIDTH-1)) h (.A(A[(WIDTH << S_WIDTH)-1:WIDTH << (S_WIDTH-1)]), .S(S[S_WIDTH-2:0]), .Y(high));
  end else begin : one
    assign {high, low} = A;
  end endgenerate
  own_mux #(.WIDTH(WIDTH)) m (.A(low), .B(high), .S(S[S_WIDTH-1]), .Y(Y));
endmodule
module own__MUX4_ (A, B, C, D, S, T, Y);
  input A, B, C, D, S, T; output Y;
  own_bmux #(.WIDTH(1), .S_WIDTH(2)) m (.A({D, C, B, A}), .S({T, S}), .Y(Y));
endmodule
module own__MUX8_ (A, B, C, D, E, F, G, H, S, T, U, Y);
  input A, B, C, D, E, F, G, H, S, T, U; output Y;
  own_bmux #(.WIDTH(1), .S_WIDTH(3)) m (.A({H, G, F, E, D, C, B, A}), .S({U, T, S}), .Y(Y));
endmodule
module own__MUX16_ (A, B, C, D, E, F, G, H, I, J, K, L, M, N, O, P, S, T, U, V, Y);
  input A, B, C, D, E, F, G, H, I, J, K, L, M, N, O, P, S, T, U, V; output Y;
  own_bmux #(.WIDTH(1), .S_WIDTH(4)) m (.A({P, O, N, M, L, K, J, I, H, G, F, E, D, C, B, A}), .S({V, U, T, S}), .Y(Y));
endmodule

// Icarus gives 0 for every negative exponent. IEEE 1364-2005, table 5-6, and Yosys' own evaluation give x for 0, 1 for 1,
// 1 or -1 for -1.
module own_pow (A, B, Y);
  parameter A_SIGNED = 0; parameter B_SIGNED = 0; parameter A_WIDTH = 1; parameter B_WIDTH = 1; parameter Y_WIDTH = 1;
  input [A_WIDTH-1:0] A; input [B_WIDTH-1:0] B; output reg [Y_WIDTH-1:0] Y;
  wire [Y_WIDTH-1:0] plain;
  generate if (A_SIGNED) assign plain = $signed(A) ** B; else assign plain = A ** B; endgenerate
  always @* begin
    Y = plain;
    if (^{A, B} === 1'bx) Y = {Y_WIDTH{1'bx}};
    else if (B_SIGNED && B[B_WIDTH-1]) begin
      if (A == 0) Y = {Y_WIDTH{1'bx}};
      else if (A_SIGNED && &A) Y = B[0] ? {Y_WIDTH{1'b1}} : 1;
      else if (A == 1) Y = 1;
      else Y = 0;
    end
  end
endmodule

// Icarus divides numbers of more than 64 bits wrongly, e.g. by 1: long division.
module long_division (A, B, Y);
  parameter A_SIGNED = 0; parameter B_SIGNED = 0; parameter A_WIDTH = 1; parameter B_WIDTH = 1; parameter Y_WIDTH = 1;
  parameter FLOOR = 0; parameter REST = 0;
  localparam BOTH = A_SIGNED && B_SIGNED;
  input [A_WIDTH-1:0] A; input [B_WIDTH-1:0] B; output reg [Y_WIDTH-1:0] Y;
  reg an, bn;
  reg [71:0] a, b, q; reg [72:0] r;
  integer i;
  always @* begin
    an = BOTH && A[A_WIDTH-1]; bn = BOTH && B[B_WIDTH-1];
    a = {{72{an}}, A}; b = {{72{bn}}, B};
    if (an) a = -a;
    if (bn) b = -b;
    q = 0; r = 0;
    for (i = 71; i >= 0; i = i - 1) begin
      r = {r, a[i]};
      if (r >= b) begin r = r - b; q[i] = 1; end
    end
    if (FLOOR && an != bn && r != 0) begin q = q + 1; r = b - r; an = bn; end
    if (REST) Y = an ? -r : r; else Y = (BOTH && A[A_WIDTH-1] != B[B_WIDTH-1]) ? -q : q;
    if (^{A, B} === 1'bx || B == 0) Y = {Y_WIDTH{1'bx}};
  end
endmodule

// New in Yosys 0.25: IEEE 1364's case equality and conditional operator (its table: see above), bit by bit.
module own_bweqx (A, B, Y);
  parameter WIDTH = 1;
  input [WIDTH-1:0] A, B; output [WIDTH-1:0] Y;
  genvar i;
  generate for (i = 0; i < WIDTH; i = i + 1) begin : bits assign Y[i] = A[i] === B[i]; end endgenerate
endmodule
module own_bwmux (A, B, S, Y);
  parameter WIDTH = 1;
  input [WIDTH-1:0] A, B, S; output [WIDTH-1:0] Y;
  genvar i;
  generate for (i = 0; i < WIDTH; i = i + 1) begin : bits choice c (A[i], B[i], S[i], Y[i]); end endgenerate
endmodule

// New in Yosys 0.49: products and addends, each extended by its own sign, added up modulo 2^Y_WIDTH.
module own_macc_v2 (A, B, C, Y);
  parameter NPRODUCTS = 1; parameter NADDENDS = 1; parameter Y_WIDTH = 1;
  parameter A_WIDTHS = 0; parameter B_WIDTHS = 0; parameter C_WIDTHS = 0;
  parameter A_SIGNED = 0; parameter B_SIGNED = 0; parameter C_SIGNED = 0;
  parameter PRODUCT_NEGATED = 0; parameter ADDEND_NEGATED = 0;
  parameter A_TOTAL = 1; parameter B_TOTAL = 1; parameter C_TOTAL = 1;
  input [A_TOTAL-1:0] A; input [B_TOTAL-1:0] B; input [C_TOTAL-1:0] C; output reg [Y_WIDTH-1:0] Y;
  integer i, j, n, at, bt, ct;
  reg [Y_WIDTH-1:0] p, q;
  always @* begin
    Y = 0; at = 0; bt = 0; ct = 0;
    for (i = 0; i < NPRODUCTS; i = i + 1) begin
      p = 0; q = 0;
      n = A_WIDTHS[16*i +: 16];
      for (j = 0; j < Y_WIDTH; j = j + 1) if (j < n) p[j] = A[at+j]; else p[j] = A_SIGNED[i] ? A[at+n-1] : 1'b0;
      at = at + n;
      n = B_WIDTHS[16*i +: 16];
      for (j = 0; j < Y_WIDTH; j = j + 1) if (j < n) q[j] = B[bt+j]; else q[j] = B_SIGNED[i] ? B[bt+n-1] : 1'b0;
      bt = bt + n;
      if (PRODUCT_NEGATED[i]) Y = Y - p * q; else Y = Y + p * q;
    end
    for (i = 0; i < NADDENDS; i = i + 1) begin
      n = C_WIDTHS[16*i +: 16];
      for (j = 0; j < Y_WIDTH; j = j + 1) if (j < n) p[j] = C[ct+j]; else p[j] = C_SIGNED[i] ? C[ct+n-1] : 1'b0;
      ct = ct + n;
      if (ADDEND_NEGATED[i]) Y = Y - p; else Y = Y + p;
    end
  end
endmodule

// Icarus has no $global_clock: a step of it is a unit of time, that is a vector of the bench.
module own_ff (D, Q);
  parameter WIDTH = 1;
  input [WIDTH-1:0] D; output reg [WIDTH-1:0] Q;
  always @(D) Q <= #1 D;
endmodule
module own__FF_ (D, Q);
  input D; output reg Q;
  always @(D) Q <= #1 D;
endmodule
