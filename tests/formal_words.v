// What modules of circuits/lib do, in words: tests/formal.rs proves them to be this. A module NAME_words has the ports
// and parameters of NAME.

module normalise_words #(parameter W = 8) (input [W-1:0] a, b, output reg [$clog2(W)-1:0] s);
  integer i;
  always @* begin
    s = {$clog2(W){1'b1}};
    for (i = 0; i < W; i = i + 1) if (a[i] | b[i]) s = W - 1 - i;
  end
endmodule

module shift_left_words #(parameter W = 8, S = $clog2(W)) (input [W-1:0] a, input [S-1:0] s, output [W-1:0] y);
  assign y = a << s;
endmodule

// Reset dominates: while both counters are 0 nothing runs.
module uu_words (input start, dt, kox_zero, koy_zero, output clk, allow_x, allow_y, \end );
  reg running;
  always @* if (kox_zero & koy_zero) running = 0; else if (start) running = 1;
  assign clk = dt & running;
  assign {allow_x, allow_y} = {!kox_zero, !koy_zero};
  assign \end  = !running;
endmodule

module magnitude_words #(parameter W = 8) (input signed [W:0] a, output negative, output [W-1:0] y);
  assign negative = a < 0;
  assign y = a < 0 ? -a : a;
endmodule

module exchange_words #(parameter W = 8) (input [W-1:0] a, b, input swap, output [W-1:0] first, second);
  assign {first, second} = swap ? {b, a} : {a, b};
endmodule

module line_axis_words #(parameter W = 8) (
    input start, input signed [W:0] d, h, input pulse, output [W-1:0] increment, output reg dir, output reg signed [W:0] t);
  assign increment = d < 0 ? -d : d;
  always @* if (start) dir = d < 0;
  always @(negedge pulse, posedge start) if (start) t <= h; else t <= dir ? t - 1 : t + 1;
endmodule

// Half-axes belong to the quadrant that begins there, or while ahead is 0 to the one that ends there. The centre, of
// which nothing is asked, is nowhere: `asked` is 0.
module quadrant_of_words #(parameter W = 8) (
    input signed [W:0] x, y, input ahead, output reg [1:0] quadrant, output [W-1:0] x_size, y_size, output asked);
  always @*
    if (y >= 0 && x > 0) quadrant = y == 0 && !ahead ? 3 : 0;
    else if (x <= 0 && y > 0) quadrant = x == 0 && !ahead ? 0 : 1;
    else if (y <= 0 && x < 0) quadrant = y == 0 && !ahead ? 1 : 2;
    else quadrant = x == 0 && !ahead ? 2 : 3;
  assign x_size = x < 0 ? -x : x;
  assign y_size = y < 0 ? -y : y;
  assign asked = x != 0 || y != 0;
endmodule

// Counter-clockwise |x| falls in quadrants 0 and 2, clockwise in 1 and 3.
module arc_end_words #(parameter W = 8) (
    input signed [W:0] x, y, xc, yc, input cw, ahead, output [1:0] quadrant, output [W-1:0] falling, rising, output asked);
  wire signed [W:0] from_x = x - xc, from_y = y - yc;
  wire [W-1:0] x_size, y_size;
  quadrant_of_words #(W) where (from_x, from_y, ahead, quadrant, x_size, y_size, asked);
  wire x_falls = (quadrant == 0 || quadrant == 2) != cw;
  assign falling = x_falls ? x_size : y_size;
  assign rising = x_falls ? y_size : x_size;
endmodule

module crossings_words #(parameter W = 8) (
    input cw, input [1:0] first, last, input [W-1:0] falling_h, rising_h, falling_k, rising_k, output reg [2:0] n);
  always @* begin
    n = (cw ? 4 + first - last : 4 + last - first) % 4;
    if (first == last && !(falling_k <= falling_h && rising_k >= rising_h && (falling_k != falling_h || rising_k != rising_h)))
      n = 4;
  end
endmodule
