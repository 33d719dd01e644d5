// Counts rotations: a divider by 5 gives a tick, a counter of two decimal digits counts the ticks while `run` is 1.
module gearbox(input clk, input rst, input run, output [7:0] shown, output full);
  wire tick;
  wire [3:0] ones, tens;
  prescaler divide (.clk(clk), .rst(rst), .tick(tick));
  digits count (.clk(clk), .rst(rst), .en(tick & run), .ones(ones), .tens(tens));
  assign shown = {tens, ones};
  assign full = shown == 8'h99;
endmodule

module prescaler(input clk, input rst, output tick);
  reg [2:0] n;
  assign tick = n == 3'd4;
  always @(posedge clk)
    if (rst) n <= 0;
    else if (tick) n <= 0;
    else n <= n + 1;
endmodule

module digits(input clk, input rst, input en, output reg [3:0] ones, output reg [3:0] tens);
  wire carry;
  assign carry = ones == 4'd9;
  always @(posedge clk)
    if (rst) begin
      ones <= 0;
      tens <= 0;
    end else if (en) begin
      ones <= carry ? 4'd0 : ones + 4'd1;
      if (carry) tens <= tens == 4'd9 ? 4'd0 : tens + 4'd1;
    end
endmodule
