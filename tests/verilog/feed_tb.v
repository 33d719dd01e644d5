// The feed system of document B as a model of its own: the line as in benches/verilog/line_rtl.v, the RC node as a voltage
// that relaxes nanosecond by nanosecond, the speed block as arithmetic on integers. Prints "time x y" at each rising edge of
// dt, and "end time". tests/feed_icarus.rs compares that with circuits/feed/system.json.
//
//   iverilog -g2005 -P feed_tb.TAU=8 -o tb.vvp benches/verilog/line_rtl.v tests/verilog/feed_tb.v && vvp -n tb.vvp
`timescale 1ns / 100ps

module feed_tb;
  parameter DX = 5, DY = 3, STEP = 20, STEP_HIGH = 10, STEP_PHASE = 10, TICK = 10, TICK_PHASE = 5, HIGH = 2;
  parameter TAU = 17, HOLD = 2, START = 22, PERIOD = 3200, CONSTANT = 1;

  reg fast = 0, clk = 0, start = 1;
  initial begin #STEP_PHASE; forever begin fast = 1; #STEP_HIGH; fast = 0; #(STEP - STEP_HIGH); end end
  initial begin #TICK_PHASE; forever begin clk = 1; #(TICK / 2); clk = 0; #(TICK - TICK / 2); end end
  initial begin #START; start = 0; #1_000_000; $display("no end"); $finish; end

  reg dt = 0, run = 0, filled = 0;
  wire step_x, step_y, ended, x, y, stop_x, stop_y, waiting_x, waiting_y;
  wire stop = stop_x | stop_y;
  wire done = ended & ~waiting_x & ~waiting_y & ~start;
  wire step_clock = fast & run;

  line_rtl #(8) line (.start(start), .dt(step_clock), .dx(DX[7:0]), .dy(DY[7:0]), .xh(8'd0), .yh(8'd0),
                      .x(step_x), .y(step_y), .done(ended), .xt(), .yt());
  store #(TAU) sync_x (start, step_x, dt, x, stop_x, waiting_x);
  store #(TAU) sync_y (start, step_y, dt, y, stop_y, waiting_y);

  // falling edges of fast since dt or start was last high
  integer quiet = 0;
  always @(negedge fast or posedge dt or posedge start)
    if (dt | start) quiet <= 0;
    else if (quiet < HOLD) quiet <= quiet + 1;
  always @(negedge fast or posedge start)
    if (start) run <= 0;
    else run <= ~stop & ~ended & quiet >= HOLD & (HOLD == 0 | ~dt);
  always @(start or stop or ended or run)
    if (start) filled = 0;
    else if ((stop | ended) & ~run) filled = 1;

  // the speed block: 16 bits of fraction, of which the period has 8 and the factor 8
  integer elapsed = 1, carried = 0, axes = 0, total;
  always @(posedge clk or posedge start)
    if (start) begin
      elapsed = 1; carried = 0; axes = 0; dt <= 0;
    end else begin
      total = carried + PERIOD * (CONSTANT == 0 || axes < 2 ? 256 : 361);
      if (dt) axes = x + y;
      if (elapsed >= total / 65536) begin
        if (filled & ~done) begin
          dt <= 1; elapsed = 1; carried = total % 65536;
        end else if (elapsed >= HIGH) dt <= 0;
      end else begin
        if (elapsed >= HIGH) dt <= 0;
        elapsed = elapsed + 1;
      end
    end

  always @(posedge dt) $strobe("%0t %b %b", $time, x, y);
  always @(posedge done) begin $display("end %0t", $time); $finish; end
  initial $timeformat(-9, 0, "", 1);
endmodule

module store #(parameter TAU = 17) (input start, step, dt, output drive, stop, waiting);
  reg t1 = 0, t2 = 0, late = 0, held = 0;
  real v = 0.0, part;
  initial part = $exp(-1.0 / (1.44 * TAU));

  // T2 as it stood between two nanoseconds drives the node to the second
  initial begin #0.5; forever begin held = t2; #1; end end
  always #1 begin
    v = held ? 1.0 - (1.0 - v) * part : v * part;
    if (held && v >= 0.5) late = 1;
    if (!held && v <= 0.5) late = 0;
  end

  wire second = step & late;
  always @(negedge dt or posedge second or posedge start)
    if (start) t1 <= 0; else if (second) t1 <= 1; else t1 <= 0;
  always @(negedge dt or posedge step or posedge start)
    if (start) t2 <= 0; else if (step) t2 <= 1; else t2 <= t1;
  assign stop = t1 & t2;
  assign waiting = t2;
  assign drive = dt & t2;
endmodule
