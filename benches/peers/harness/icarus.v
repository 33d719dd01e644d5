// Toggles the clock of a design: +cycles=N [+trace=FILE]. One cycle of reset comes before.
`timescale 1ns / 1ns
module bench;
  reg clk = 0, rst = 1;
  wire [31:0] checksum;
  `TOP dut (.clk(clk), .rst(rst), .checksum(checksum));
  integer cycles, n;
  reg [8*256-1:0] file;
  initial begin
    if (!$value$plusargs("cycles=%d", cycles)) cycles = 1000;
    if ($value$plusargs("trace=%s", file)) begin
      $dumpfile(file);
      $dumpvars(0, dut);
    end
    for (n = 0; n <= cycles; n = n + 1) begin
      #1 clk = 1;
      #1 clk = 0;
      rst = 0;
    end
    #0 $display("checksum=%08x", checksum);
    $finish;
  end
endmodule
