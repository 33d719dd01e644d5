// A round-robin arbiter, N requests: the one behind the last granted comes first. Its clients hold their grants for as
// long as each of them wants, counted in a small register of each.

module first #(parameter N = 5) (input [N-1:0] in, output [N-1:0] one);
  assign one = in & (~in + 1);
endmodule

module client #(parameter N = 5, parameter NUMBER = 0) (
  input clk, input rst, input ask, input granted, output request, output reg [3:0] left, output reg [7:0] served
);
  assign request = left != 0;
  always @(posedge clk or posedge rst)
    if (rst) begin
      left <= 0;
      served <= 0;
    end else if (ask & ~request) left <= NUMBER + 1;
    else if (granted) begin
      left <= left - 1'b1;
      if (left == 1) served <= served + 1;
    end
endmodule

module arbiter #(parameter N = 5) (
  input clk, input rst, input [N-1:0] ask, output reg [N-1:0] grant, output reg [2:0] who, output [N*8-1:0] served,
  output [N-1:0] requests
);
  reg [N-1:0] below;  // ones where a request comes later than the last grant
  wire [N-1:0] later, any;
  first #(N) first_later (.in(requests & ~below), .one(later));
  first #(N) first_any (.in(requests), .one(any));
  wire keeps = |(grant & requests);
  wire [N-1:0] next = keeps ? grant : |later ? later : any;

  genvar g;
  generate
    for (g = 0; g < N; g = g + 1) begin : port
      client #(.N(N), .NUMBER(g)) client (
        .clk(clk), .rst(rst), .ask(ask[g]), .granted(grant[g]), .request(requests[g]), .left(), .served(served[8*g +: 8]));
    end
  endgenerate

  integer i;
  always @* begin
    who = 3'd7;
    for (i = N - 1; i >= 0; i = i - 1) if (grant[i]) who = i;
  end
  always @(posedge clk or posedge rst)
    if (rst) begin
      grant <= 0;
      below <= 0;
    end else begin
      grant <= next;
      if (|next) below <= next | (next - 1'b1);
    end
endmodule
