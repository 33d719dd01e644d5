// A counter of two bits as a tool leaves it: cells of small.lib, a clock gate of a latch and an AND, fillers.
module counter(clk, rst_n, en, q);
  input clk, rst_n, en;
  output [1:0] q;
  wire clk_n, open, held, gated_n, gated, d0, d1;
  SM_INV  i0 (.A(clk), .Y(clk_n));
  SM_LAT  l0 (.E(clk_n), .D(en), .Q(open));
  SM_NAND2 g0 (.A(clk), .B(open), .Y(gated_n));
  SM_INV  i1 (.A(gated_n), .Y(gated));
  SM_INV  i2 (.A(q[0]), .Y(d0));
  SM_XOR2 x0 (.A(q[0]), .B(q[1]), .Y(d1));
  SM_DFFR f0 (.CK(gated), .D(d0), .RN(rst_n), .Q(q[0]));
  SM_DFFR f1 (.CK(gated), .D(d1), .RN(rst_n), .Q(q[1]));
  SM_FILL fill_0 ();
  SM_FILL fill_1 ();
endmodule
