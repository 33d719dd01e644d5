// CRC-32 (reflected, 04c11db7): a byte a clock by a function, and a bit a clock by a shift register; they must agree.

module crc_bytes (input clk, input clear, input enable, input [7:0] data, output reg [31:0] state);
  function [31:0] step(input [31:0] from, input [7:0] byte_in);
    integer i;
    begin
      step = from ^ {24'd0, byte_in};
      for (i = 0; i < 8; i = i + 1) step = step[0] ? (step >> 1) ^ 32'hedb88320 : step >> 1;
    end
  endfunction
  always @(posedge clk)
    if (clear) state <= 32'hffffffff;
    else if (enable) state <= step(state, data);
endmodule

module crc_bits (input clk, input clear, input enable, input in, output reg [31:0] state);
  wire turn = in ^ state[0];
  genvar i;
  generate
    for (i = 0; i < 32; i = i + 1) begin : place
      wire above;
      if (i == 31) assign above = 1'b0;
      else assign above = state[i+1];
      localparam [31:0] TAPS = 32'hedb88320;
      always @(posedge clk)
        if (clear) state[i] <= 1'b1;
        else if (enable) state[i] <= TAPS[i] ? above ^ turn : above;
    end
  endgenerate
endmodule

module crc (
  input clk, input clear, input start, input [7:0] data, output ready, output [31:0] sum, output [31:0] serial_sum,
  output agree
);
  reg [7:0] shift;
  reg [3:0] left;
  wire [31:0] by_bytes, by_bits;
  assign ready = left == 0;
  assign sum = ~by_bytes;
  assign serial_sum = ~by_bits;
  assign agree = ~ready | by_bytes == by_bits;
  crc_bytes bytes (.clk(clk), .clear(clear), .enable(start & ready), .data(data), .state(by_bytes));
  crc_bits bits (.clk(clk), .clear(clear), .enable(~ready), .in(shift[0]), .state(by_bits));
  always @(posedge clk)
    if (clear) begin
      shift <= 0;
      left <= 0;
    end else if (ready) begin
      if (start) begin
        shift <= data;
        left <= 8;
      end
    end else begin
      shift <= {1'bx, shift[7:1]};
      left <= left - 1;
    end
endmodule
