// Models of cells for which the simulation library that is installed (Yosys 0.23 and on) has none, or none that can be
// compared. Each says why it is here, and where its meaning comes from.

// New in Yosys 0.36: a buffer that is a wire.
module own_buf (A, Y);
  parameter A_SIGNED = 0; parameter A_WIDTH = 1; parameter Y_WIDTH = 1;
  input [A_WIDTH-1:0] A; output [Y_WIDTH-1:0] Y;
  generate if (A_SIGNED) assign Y = $signed(A); else assign Y = A; endgenerate
endmodule

// In the library of Yosys 0.70, not in that of 0.23: a wire that optimising leaves alone.
module own_barrier (A, Y);
  parameter WIDTH = 1;
  input [WIDTH-1:0] A; output [WIDTH-1:0] Y;
  assign Y = A;
endmodule

// Icarus looks at the low 32 bits of an index alone, whatever x is above them.
module own_shiftx (A, B, Y);
  parameter A_SIGNED = 0; parameter B_SIGNED = 0; parameter A_WIDTH = 1; parameter B_WIDTH = 1; parameter Y_WIDTH = 1;
  input [A_WIDTH-1:0] A; input [B_WIDTH-1:0] B; output reg [Y_WIDTH-1:0] Y;
  reg signed [143:0] at; integer i;
  always @* for (i = 0; i < Y_WIDTH; i = i + 1) begin
    at = $signed({{144{B_SIGNED && B[B_WIDTH-1]}}, B}) + i;
    Y[i] = (^B === 1'bx || at < 0 || at >= A_WIDTH) ? 1'bx : A[at[31:0]];
  end
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

// A memory as the library's $mem_v2, but
// - its clocks have IEEE 1364's edges (9.7.2), as those of the always blocks have that it stands for: the library knows
//   0 to 1 and 1 to 0 alone, and takes z for either;
// - ports without a clock write before and after those with one, as they act by level: in the library it depends on
//   what else wakes the block.
// With V1 its transparency is that of $mem as Yosys reads it: RD_TRANSPARENT makes a port transparent to the write ports
// with the same clock, which SAME says, and enabled it must be as any other. The library takes no notice of RD_EN there.
module own_mem_v2 (RD_CLK, RD_EN, RD_ARST, RD_SRST, RD_ADDR, RD_DATA, WR_CLK, WR_EN, WR_ADDR, WR_DATA);
  parameter MEMID = ""; parameter signed SIZE = 4; parameter signed OFFSET = 0; parameter signed ABITS = 2;
  parameter signed WIDTH = 8; parameter signed INIT = 1'bx;
  parameter signed RD_PORTS = 1; parameter RD_CLK_ENABLE = 0; parameter RD_CLK_POLARITY = 0;
  parameter RD_TRANSPARENCY_MASK = 0; parameter RD_COLLISION_X_MASK = 0; parameter RD_WIDE_CONTINUATION = 0;
  parameter RD_CE_OVER_SRST = 0; parameter RD_ARST_VALUE = 0; parameter RD_SRST_VALUE = 0;
  parameter RD_INIT_VALUE = {RD_PORTS*WIDTH{1'bx}};
  parameter signed WR_PORTS = 1; parameter WR_CLK_ENABLE = 0; parameter WR_CLK_POLARITY = 0;
  parameter WR_PRIORITY_MASK = 0; parameter WR_WIDE_CONTINUATION = 0;
  parameter V1 = 0; parameter RD_TRANSPARENT = 0; parameter SAME = 0;
  localparam WP = WR_PORTS > 0 ? WR_PORTS : 1;
  localparam TRANSPARENT = RD_TRANSPARENCY_MASK, COLLIDES = RD_COLLISION_X_MASK;
  input [RD_PORTS-1:0] RD_CLK, RD_EN, RD_ARST, RD_SRST; input [RD_PORTS*ABITS-1:0] RD_ADDR;
  output reg [RD_PORTS*WIDTH-1:0] RD_DATA;
  input [WP-1:0] WR_CLK; input [WP*WIDTH-1:0] WR_EN, WR_DATA; input [WP*ABITS-1:0] WR_ADDR;
  reg [WIDTH-1:0] memory [0:SIZE-1];
  reg [RD_PORTS-1:0] rd_old, rd_seen, rd_edge; reg [WP-1:0] wr_old, wr_seen, wr_edge;
  integer i, j, k;

  function active (input positive, input old, input now);
    reg a, b;
    begin
      a = old ^ 1'b0; b = now ^ 1'b0;
      active = a !== b && (positive ? a === 0 || b === 1 : a === 1 || b === 0);
    end
  endfunction

  task write (input clocked);
    for (i = 0; i < WR_PORTS; i = i + 1)
      if (clocked ? WR_CLK_ENABLE[i] && wr_edge[i] : !WR_CLK_ENABLE[i])
        for (j = 0; j < WIDTH; j = j + 1)
          if (WR_EN[i*WIDTH+j] === 1'b1) memory[WR_ADDR[i*ABITS +: ABITS] - OFFSET][j] = WR_DATA[i*WIDTH+j];
  endtask

  initial begin
    for (i = 0; i < SIZE; i = i + 1) memory[i] = INIT >>> (i*WIDTH);
    RD_DATA = RD_INIT_VALUE; rd_seen = 0; wr_seen = 0;
  end

  always @(RD_CLK, RD_EN, RD_ARST, RD_SRST, RD_ADDR, WR_CLK, WR_EN, WR_ADDR, WR_DATA) begin
    #0;
    for (i = 0; i < RD_PORTS; i = i + 1) begin
      rd_edge[i] = rd_seen[i] && active(RD_CLK_POLARITY[i], rd_old[i], RD_CLK[i]);
      rd_seen[i] = rd_seen[i] || (RD_CLK[i] ^ 1'b0) !== 1'bx;
    end
    for (i = 0; i < WR_PORTS; i = i + 1) begin
      wr_edge[i] = wr_seen[i] && active(WR_CLK_POLARITY[i], wr_old[i], WR_CLK[i]);
      wr_seen[i] = wr_seen[i] || (WR_CLK[i] ^ 1'b0) !== 1'bx;
    end
    rd_old = RD_CLK; wr_old = WR_CLK;
    write(0);
    for (i = 0; i < RD_PORTS; i = i + 1) if (RD_CLK_ENABLE[i] && rd_edge[i]) begin
      if (!V1 && RD_SRST[i] === 1'b1 && (RD_EN[i] === 1'b1 || !RD_CE_OVER_SRST[i]))
        RD_DATA[i*WIDTH +: WIDTH] = RD_SRST_VALUE >> (i*WIDTH);
      else if (RD_EN[i] === 1'b1) begin
        RD_DATA[i*WIDTH +: WIDTH] = memory[RD_ADDR[i*ABITS +: ABITS] - OFFSET];
        for (j = 0; j < WR_PORTS; j = j + 1)
          if (WR_CLK_ENABLE[j] && wr_edge[j] && (RD_ADDR[i*ABITS +: ABITS] == WR_ADDR[j*ABITS +: ABITS]) === 1'b1)
            for (k = 0; k < WIDTH; k = k + 1) if (WR_EN[j*WIDTH+k] === 1'b1) begin
              if (V1 ? RD_TRANSPARENT[i] && SAME[i*WR_PORTS+j] : TRANSPARENT[i*WR_PORTS+j])
                RD_DATA[i*WIDTH+k] = WR_DATA[j*WIDTH+k];
              if (!V1 && COLLIDES[i*WR_PORTS+j]) RD_DATA[i*WIDTH+k] = 1'bx;
            end
      end
    end
    write(1);
    write(0);
    for (i = 0; i < RD_PORTS; i = i + 1) begin
      if (!RD_CLK_ENABLE[i]) RD_DATA[i*WIDTH +: WIDTH] = memory[RD_ADDR[i*ABITS +: ABITS] - OFFSET];
      if (!V1 && RD_ARST[i] === 1'b1) RD_DATA[i*WIDTH +: WIDTH] = RD_ARST_VALUE >> (i*WIDTH);
    end
  end
endmodule
