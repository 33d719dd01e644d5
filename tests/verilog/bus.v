// A bus with tri-state drivers: registers that are written from it and put onto it, and a port to the outside that goes
// both ways.

module unit #(parameter ADDRESS = 0) (
  input clk, input rst, input [1:0] address, input read, input write, inout [7:0] bus, output reg [7:0] value
);
  wire chosen = address == ADDRESS;
  assign bus = chosen & read ? value : 8'bz;
  always @(posedge clk or posedge rst)
    if (rst) value <= 8'h11 * (ADDRESS + 1);
    else if (chosen & write) value <= bus;
    else value <= {value[6:0], value[7]};
endmodule

module pad (inout pin, input out, input drive, output in);
  assign pin = drive ? out : 1'bz;
  assign in = pin;
endmodule

module bus (
  input clk, input rst, input [1:0] address, input read, input write, input inward, input outward,
  inout [7:0] pins, output [7:0] seen, output [31:0] values, output reg [7:0] last, output reg some
);
  wire [7:0] shared, from_pins;
  genvar i;
  generate
    for (i = 0; i < 4; i = i + 1) begin : at
      unit #(.ADDRESS(i)) unit (
        .clk(clk), .rst(rst), .address(address), .read(read), .write(write), .bus(shared), .value(values[8*i +: 8]));
    end
    for (i = 0; i < 8; i = i + 1) begin : pin
      pad pad (.pin(pins[i]), .out(shared[i]), .drive(outward), .in(from_pins[i]));
    end
  endgenerate
  assign shared = inward ? from_pins : 8'bz;
  assign shared[3:0] = ~read & ~inward & write ? 4'h9 : 4'bz;
  assign seen = from_pins;
  always @(posedge clk) begin
    last <= shared;
    some <= |shared;
  end
endmodule
