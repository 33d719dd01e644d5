// What the golden trace was made with: iverilog -o tb gearbox_tb.v gearbox.v && ./tb
`timescale 1ns/1ns
module bench;
  reg clk = 0, rst = 1, run = 1;
  wire [7:0] shown;
  wire full;
  gearbox dut (.clk(clk), .rst(rst), .run(run), .shown(shown), .full(full));
  always #5 clk = !clk;
  initial begin
    $dumpfile("golden.vcd");
    $dumpvars(0, dut);
    #12 rst = 0;
    #788 $finish;
  end
endmodule
