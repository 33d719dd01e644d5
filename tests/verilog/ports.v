// Ports whose bits are hard: repeated, constant, handed through, overlapping, counted upwards.
module repeats(input [1:0] a, output [3:0] y, output [2:0] k, output [0:5] mixed);
  assign y = {a[0], &a, a[0], &a};
  assign k = {3{a[1]}};
  assign mixed = {1'b1, ^a, 1'b0, {2{|a}}, a[1]};
endmodule

module through(input [7:0] d, output [7:0] same, output [0:7] turned, output [11:4] shifted, output [2:0] low);
  assign same = d;
  assign turned = {d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
  assign shifted = {d[3:0], d[7:4]};
  assign low = d;
endmodule

module held(input clk, input r, input [3:0] d, output [7:0] q, output reg [3:0] first, output [3:0] second);
  always @(posedge clk) if (r) first <= 0; else first <= d;
  assign second = first;
  assign q = {2{first}};
endmodule

module rom(input [1:0] at, output [3:0] word, output [7:0] twice);
  reg [3:0] m [0:3];
  initial begin m[0] = 1; m[1] = 7; m[2] = 4; m[3] = 9; end
  assign word = m[at];
  assign twice = {2{m[at]}};
endmodule

module top(input clk, input r, input [1:0] a, input [0:64] b, output [3:0] o0, output [7:0] o1, output [2:0] o2,
           output [64:0] o3, output [0:64] o4, output [12:5] o5, output [7:0] o6, output [9:0] o7, output o8,
           output [129:0] o9);
  wire [7:0] same, turned, shifted;
  wire [2:0] low;
  repeats u(.a(a), .y(o0), .k(o2), .mixed());
  repeats v(.a({2{a[1]}}), .y(), .k(), .mixed(o1[7:2]));
  assign o1[1:0] = {2{o1[4]}};
  through w(.d({b[0:3], 2'b10, a}), .same(same), .turned(turned), .shifted(shifted), .low(low));
  through x(.d(same), .same(), .turned(o5), .shifted(), .low());
  held y(.clk(clk), .r(r), .d(same[5:2]), .q(o6), .first(), .second());
  rom z(.at({a[0], a[0]}), .word(o7[3:0]), .twice());
  assign o7[9:4] = {a, o7[0], low};
  assign o3 = b;
  assign o4 = {b[1:64], b[0]};
  assign o8 = 1'b1;
  assign o9 = {2{b}};
endmodule
