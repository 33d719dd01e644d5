// Clocks made of clocks: gated through a latch, divided, by a ripple counter, of both edges, chosen between two; resets
// that come asynchronously, leave synchronously, and a set beside a clear.

module gate (input clk, input enable, output gated);
  reg open;
  always @* if (!clk) open = enable;
  assign gated = clk & open;
endmodule

module reset_synchroniser (input clk, input rst_n, output rst_n_out);
  reg [1:0] through;
  always @(posedge clk or negedge rst_n)
    if (!rst_n) through <= 0;
    else through <= {through[0], 1'b1};
  assign rst_n_out = through[1];
endmodule

module toggle (input clk, input rst_n, output reg q);
  always @(negedge clk or negedge rst_n)
    if (!rst_n) q <= 0;
    else q <= ~q;
endmodule

module ripple #(parameter W = 5) (input clk, input rst_n, output [W-1:0] count);
  genvar i;
  generate
    for (i = 0; i < W; i = i + 1) begin : place
      wire in;
      if (i == 0) begin : first
        assign in = clk;
      end else begin : other
        assign in = count[i-1];
      end
      toggle t (.clk(in), .rst_n(rst_n), .q(count[i]));
    end
  endgenerate
endmodule

module divide_by_three (input clk, input rst_n, output out);
  reg [1:0] up;
  reg down;
  always @(posedge clk or negedge rst_n)
    if (!rst_n) up <= 0;
    else up <= up == 2 ? 0 : up + 1;
  always @(negedge clk or negedge rst_n)
    if (!rst_n) down <= 0;
    else down <= up[1];
  assign out = up[1] | down;  // half of the time
endmodule

module both_edges (input clk, input rst, input [3:0] d, output [3:0] q);
  reg [3:0] rising, falling;
  always @(posedge clk or posedge rst)
    if (rst) rising <= 0;
    else rising <= d ^ falling;
  always @(negedge clk or posedge rst)
    if (rst) falling <= 0;
    else falling <= d ^ rising;
  assign q = rising ^ falling;
endmodule

module choose (input clk0, input clk1, input select, input rst_n, output out);
  reg on0, on1;
  always @(negedge clk0 or negedge rst_n)
    if (!rst_n) on0 <= 0;
    else on0 <= ~select & ~on1;
  always @(negedge clk1 or negedge rst_n)
    if (!rst_n) on1 <= 0;
    else on1 <= select & ~on0;
  assign out = clk0 & on0 | clk1 & on1;
endmodule

module counter #(parameter W = 8, parameter [W-1:0] FROM = 0) (input clk, input rst_n, output reg [W-1:0] q);
  always @(posedge clk or negedge rst_n)
    if (!rst_n) q <= FROM;
    else q <= q + 1;
endmodule

module clocks (
  input clk, input other, input rst_n, input enable, input select, input [3:0] d, input set, input clear,
  output [4:0] rippled, output third, output [3:0] fast, output [7:0] gated_count, output [7:0] third_count,
  output [7:0] chosen_count, output reg held, output local_rst_n, output reg [3:0] captured
);
  wire gated, chosen;
  gate gate (.clk(clk), .enable(enable), .gated(gated));
  reset_synchroniser resets (.clk(clk), .rst_n(rst_n), .rst_n_out(local_rst_n));
  ripple ripple (.clk(clk), .rst_n(rst_n), .count(rippled));
  divide_by_three divide (.clk(clk), .rst_n(rst_n), .out(third));
  both_edges both (.clk(clk), .rst(~local_rst_n), .d(d), .q(fast));
  choose choose (.clk0(clk), .clk1(other), .select(select), .rst_n(rst_n), .out(chosen));
  counter #(.FROM(8'hf0)) on_gated (.clk(gated), .rst_n(local_rst_n), .q(gated_count));
  counter on_third (.clk(third), .rst_n(rst_n), .q(third_count));
  counter #(.FROM(8'd7)) on_chosen (.clk(chosen), .rst_n(rst_n), .q(chosen_count));
  always @(posedge other or posedge clear or posedge set)
    if (clear) held <= 0;
    else if (set) held <= 1;
    else held <= d[0];
  // clocked by data of another flip-flop
  always @(posedge rippled[1] or negedge rst_n)
    if (!rst_n) captured <= 4'b1010;
    else captured <= d;
endmodule
