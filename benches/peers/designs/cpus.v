// N computers of tests/verilog/cpu, each of which begins some cycles after the one before it and begins anew when its
// program ends; a checksum of what they print.
module computer #(parameter PROGRAM = "program.hex") (
  input             clk,
  input             rst,
  input      [11:0] delay,
  output reg [31:0] checksum
);
  reg [11:0] left;
  wire put, done, trap;
  wire [7:0] character;
  wire [31:0] status;
  cpu #(.PROGRAM(PROGRAM)) cpu (
    .clk(clk), .rst(rst | left != 0 | done), .put(put), .character(character), .done(done), .status(status), .trap(trap)
  );
  always @(posedge clk)
    if (rst) begin
      left <= delay;
      checksum <= 0;
    end else begin
      if (left != 0) left <= left - 1'b1;
      if (put | done) checksum <= {checksum[26:0], checksum[31:27]} ^ {trap, status[22:0], character};
    end
endmodule

module cpus #(parameter N = 1, parameter PROGRAM = "program.hex") (
  input             clk,
  input             rst,
  output reg [31:0] checksum
);
  wire [32*N-1:0] each;
  genvar i;
  generate
    for (i = 0; i < N; i = i + 1) begin : at
      computer #(.PROGRAM(PROGRAM)) computer (
        .clk(clk), .rst(rst), .delay(12'd37 * i[5:0]), .checksum(each[32*i +: 32])
      );
    end
  endgenerate
  integer k;
  always @* begin
    checksum = 0;
    for (k = 0; k < N; k = k + 1) checksum = {checksum[30:0], checksum[31]} ^ each[32*k +: 32];
  end
endmodule
