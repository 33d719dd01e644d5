// Memories in the ways in which Verilog describes them: written by bytes, read at once and at the edges of two clocks,
// filled from a file and by a loop, with a range of addresses of its own, and one that nothing writes.
module memory (
  input clk, input clk2, input [3:0] we, input [4:0] a, input [4:0] b, input [31:0] d, input en, input rst,
  output [31:0] now, output reg [31:0] old, output reg [31:0] fresh, output reg [31:0] other,
  output [6:0] digit, output [7:0] popped
);
  reg [31:0] ram [3:22];
  initial $readmemh("memory.hex", ram);

  integer i;
  always @(posedge clk)
    for (i = 0; i < 4; i = i + 1) if (we[i]) ram[a][8*i +: 8] <= d[8*i +: 8];

  // at once
  assign now = ram[b];

  // what was there before the edge that writes
  always @(posedge clk) if (en) old <= ram[b];

  // with a reset, by a clock of its own
  always @(negedge clk2) if (rst) other <= 32'hdeadbeef; else if (en) other <= ram[b];

  // an address that is kept: what is there after the edge
  reg [4:0] kept;
  always @(posedge clk) kept <= b;
  always @* fresh = ram[kept];

  // a table
  reg [6:0] table7 [0:15];
  initial begin
    for (i = 0; i < 16; i = i + 1) table7[i] = 7'h7f - i * 3;
    table7[5] = 7'bx01x10x;
  end
  assign digit = table7[now[3:0]];

  stack stack (.clk(clk), .push(we[0]), .pop(en), .in(d[7:0]), .out(popped));
endmodule

module stack (input clk, input push, input pop, input [7:0] in, output [7:0] out);
  reg [7:0] words [0:7];
  reg [2:0] top = 0;
  wire [2:0] next = top + 1;
  assign out = words[top];
  always @(posedge clk) begin
    if (push) begin
      words[next] <= in;
      top <= next;
    end else if (pop) top <= top - 1;
  end
endmodule
