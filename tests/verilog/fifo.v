// A queue between two clocks: its pointers cross in Gray code through two flip-flops each.

module synchroniser #(parameter W = 4) (input clk, input rst_n, input [W-1:0] d, output reg [W-1:0] q);
  reg [W-1:0] between;
  always @(posedge clk or negedge rst_n)
    if (!rst_n) {q, between} <= 0;
    else {q, between} <= {between, d};
endmodule

module gray_counter #(parameter W = 4) (
  input clk, input rst_n, input step, output reg [W-1:0] binary, output reg [W-1:0] gray
);
  wire [W-1:0] next = binary + {{W-1{1'b0}}, step};
  always @(posedge clk or negedge rst_n)
    if (!rst_n) begin
      binary <= 0;
      gray <= 0;
    end else begin
      binary <= next;
      gray <= next ^ (next >> 1);
    end
endmodule

module gray_to_binary #(parameter W = 4) (input [W-1:0] gray, output [W-1:0] binary);
  genvar i;
  generate
    for (i = 0; i < W; i = i + 1) begin : place
      assign binary[i] = ^(gray >> i);
    end
  endgenerate
endmodule

module fifo #(parameter W = 8, parameter BITS = 3) (
  input write_clk, input write_rst_n, input push, input [W-1:0] data, output full, output [BITS:0] free,
  input read_clk, input read_rst_n, input pop, output [W-1:0] head, output empty, output reg [W-1:0] taken
);
  reg [W-1:0] words [0:(1<<BITS)-1];
  wire [BITS:0] write_at, write_gray, read_at, read_gray, write_seen, read_seen, read_seen_binary;
  wire pushes = push & ~full, pops = pop & ~empty;

  gray_counter #(BITS+1) writer (.clk(write_clk), .rst_n(write_rst_n), .step(pushes), .binary(write_at), .gray(write_gray));
  gray_counter #(BITS+1) reader (.clk(read_clk), .rst_n(read_rst_n), .step(pops), .binary(read_at), .gray(read_gray));
  synchroniser #(BITS+1) to_read (.clk(read_clk), .rst_n(read_rst_n), .d(write_gray), .q(write_seen));
  synchroniser #(BITS+1) to_write (.clk(write_clk), .rst_n(write_rst_n), .d(read_gray), .q(read_seen));
  gray_to_binary #(BITS+1) seen (.gray(read_seen), .binary(read_seen_binary));

  assign full = write_gray == {~read_seen[BITS:BITS-1], read_seen[BITS-2:0]};
  assign empty = read_gray == write_seen;
  assign free = (1 << BITS) - (write_at - read_seen_binary);
  assign head = words[read_at[BITS-1:0]];
  always @(posedge write_clk) if (pushes) words[write_at[BITS-1:0]] <= data;
  always @(posedge read_clk) if (pops) taken <= head;
endmodule
