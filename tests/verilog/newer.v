// What newer versions of Yosys make cells of their own of: an asynchronous load, sums of products, messages, assertions.
module shifted (input [7:0] a, input [7:0] b, output signed [15:0] mac);
  assign mac = $signed(a) * $signed(b) + $signed(b) * $signed(8'd3) - $signed(a);
endmodule

module newer (input clk, input rst, input load, input [7:0] a, input [7:0] b, output reg [15:0] acc, output [15:0] mac,
              output reg [7:0] q);
  shifted sum (.a(a), .b(b), .mac(mac));
  always @(posedge clk or posedge load)
    if (load) q <= a ^ b;
    else q <= q + 1;
  always @(posedge clk)
    if (rst) acc <= 0;
    else acc <= acc + a * b - q;
  always @(posedge clk)
    if (!rst) begin
      $display("acc=%d q=%h mac=%b", acc, q, mac);
`ifdef YOSYS
      assert (mac != 16'd77);
      cover (q == 8'h3a);
`endif
    end
endmodule
