// Runs the computer as the top module, so that its nets have the names that they have in a netlist of it.
`timescale 1ns/1ns
module bench;
  reg clk = 0;
  always #5 clk = ~clk;
  initial begin
    $dumpfile("target/icarus.vcd");
    $dumpvars(0, cpu);
    force cpu.clk = clk;
    force cpu.rst = 0;
    wait (cpu.done) #1 $finish;
  end
endmodule
