// A computer: a core for RV32I (no CSRs, no interrupts), 16 KiB of memory, an output port and a port that ends it.
//
//   0000_0000 to 0000_3fff  memory, loaded from PROGRAM
//   1000_0000               write: a character for the output port
//   1000_0004               write: the program ends with this status
//   1000_0008               read: clock cycles since reset
//
// An instruction takes two cycles, a load or store three: memory has one port and gives its word in the next cycle, so
// an instruction is decoded while it comes, and the next one is fetched while it is executed.

module alu (
  input [31:0] a,
  input [31:0] b,
  input [2:0] operation,  // funct3
  input other,            // subtract, shift arithmetically
  output reg [31:0] y,
  output equal,
  output less,
  output less_unsigned
);
  wire [32:0] difference = {1'b0, a} - {1'b0, b};
  wire signed [31:0] as = a;
  assign equal = a == b;
  assign less_unsigned = difference[32];
  assign less = a[31] != b[31] ? a[31] : difference[32];
  always @*
    case (operation)
      3'd0: y = other ? difference[31:0] : a + b;
      3'd1: y = a << b[4:0];
      3'd2: y = {31'd0, less};
      3'd3: y = {31'd0, less_unsigned};
      3'd4: y = a ^ b;
      3'd5:
        if (other) y = as >>> b[4:0];
        else y = a >> b[4:0];
      3'd6: y = a | b;
      3'd7: y = a & b;
    endcase
endmodule

module registers (
  input clk,
  input [4:0] rs1,
  input [4:0] rs2,
  output [31:0] value1,
  output [31:0] value2,
  input write,
  input [4:0] rd,
  input [31:0] data
);
  reg [31:0] x [0:31];
  assign value1 = rs1 == 0 ? 32'd0 : x[rs1];
  assign value2 = rs2 == 0 ? 32'd0 : x[rs2];
  always @(posedge clk) if (write) x[rd] <= data;
endmodule

// What an instruction says.
module decoder (
  input [31:0] instruction,
  output load,
  output store,
  output branch,
  output jal,
  output jalr,
  output lui,
  output auipc,
  output register_immediate,
  output register_register,
  output illegal,
  output reg [31:0] immediate
);
  wire [6:0] opcode = instruction[6:0];
  assign load = opcode == 7'b0000011;
  assign store = opcode == 7'b0100011;
  assign branch = opcode == 7'b1100011;
  assign jal = opcode == 7'b1101111;
  assign jalr = opcode == 7'b1100111;
  assign lui = opcode == 7'b0110111;
  assign auipc = opcode == 7'b0010111;
  assign register_immediate = opcode == 7'b0010011;
  assign register_register = opcode == 7'b0110011;
  wire fence = opcode == 7'b0001111;
  assign illegal = ~|{load, store, branch, jal, jalr, lui, auipc, register_immediate, register_register, fence};
  always @*
    case (1'b1)
      store: immediate = {{21{instruction[31]}}, instruction[30:25], instruction[11:7]};
      branch: immediate = {{20{instruction[31]}}, instruction[7], instruction[30:25], instruction[11:8], 1'b0};
      jal: immediate = {{12{instruction[31]}}, instruction[19:12], instruction[20], instruction[30:21], 1'b0};
      lui, auipc: immediate = {instruction[31:12], 12'd0};
      default: immediate = {{21{instruction[31]}}, instruction[30:20]};
    endcase
endmodule

// How a load or store of 1, 2 or 4 bytes (funct3) lies in a word.
module lanes (
  input [2:0] size,
  input [1:0] address,
  input [31:0] stored,
  output [31:0] write_data,
  output reg [3:0] write_mask,
  output reg misaligned,
  input [31:0] read_data,
  output reg [31:0] loaded
);
  assign write_data = size[1:0] == 0 ? {4{stored[7:0]}} : size[1:0] == 1 ? {2{stored[15:0]}} : stored;
  wire [15:0] half = address[1] ? read_data[31:16] : read_data[15:0];
  wire [7:0] one = address[0] ? half[15:8] : half[7:0];
  always @* begin
    case (size[1:0])
      2'd0: {misaligned, write_mask} = {1'b0, 4'b0001 << address};
      2'd1: {misaligned, write_mask} = {address[0], address[1] ? 4'b1100 : 4'b0011};
      default: {misaligned, write_mask} = {|address, 4'b1111};
    endcase
    case (size[1:0])
      2'd0: loaded = {{24{one[7] & ~size[2]}}, one};
      2'd1: loaded = {{16{half[15] & ~size[2]}}, half};
      default: loaded = read_data;
    endcase
  end
endmodule

module core #(parameter [31:0] START = 0) (
  input clk,
  input rst,
  output request,             // the word at `address` is wanted in the next cycle, or written
  output [31:0] address,
  output [31:0] write_data,
  output [3:0] write_mask,    // which bytes are written; 0 to read
  input [31:0] read_data,
  output reg trap             // something that it cannot do; it has stopped
);
  localparam [1:0] FETCH = 0, DECODE = 1, EXECUTE = 2, MEMORY = 3;
  reg [1:0] state;
  reg [31:0] pc, instruction, a, b, immediate;
  reg load, store, branch, jal, jalr, lui, auipc, by_immediate, by_register;

  // decoding, while the instruction comes from memory
  wire is_load, is_store, is_branch, is_jal, is_jalr, is_lui, is_auipc, is_by_immediate, is_by_register, illegal;
  wire [31:0] its_immediate, value1, value2;
  decoder decoder (
    .instruction(read_data), .load(is_load), .store(is_store), .branch(is_branch), .jal(is_jal), .jalr(is_jalr),
    .lui(is_lui), .auipc(is_auipc), .register_immediate(is_by_immediate), .register_register(is_by_register),
    .illegal(illegal), .immediate(its_immediate)
  );

  // executing
  wire [2:0] funct3 = instruction[14:12];
  wire [31:0] result, loaded;
  wire equal, less, less_unsigned;
  alu alu (
    .a(a), .b(by_immediate ? immediate : b), .operation(funct3),
    .other(instruction[30] & (by_register | funct3 == 3'd5)),
    .y(result), .equal(equal), .less(less), .less_unsigned(less_unsigned)
  );
  reg taken;
  always @*
    case (funct3[2:1])
      2'd0: taken = equal ^ funct3[0];
      2'd2: taken = less ^ funct3[0];
      2'd3: taken = less_unsigned ^ funct3[0];
      default: taken = 1'b0;
    endcase
  wire [31:0] sum = (load | store | jalr ? a : pc) + immediate;
  wire [31:0] following = pc + 4;
  wire [31:0] next = jal | branch & taken ? sum : jalr ? {sum[31:1], 1'b0} : following;

  wire [3:0] mask;
  wire misaligned;
  lanes lanes (
    .size(funct3), .address(sum[1:0]), .stored(b), .write_data(write_data), .write_mask(mask),
    .misaligned(misaligned), .read_data(read_data), .loaded(loaded)
  );

  wire access = state == EXECUTE & (load | store);
  wire fault = state == DECODE & illegal | access & misaligned | state == EXECUTE & next[1];
  assign request = ~trap & ~fault & state != DECODE;
  assign address = access ? sum : state == EXECUTE ? next : pc;
  assign write_mask = access & store ? mask : 4'd0;

  wire writes = by_immediate | by_register | jal | jalr | lui | auipc;
  registers registers (
    .clk(clk), .rs1(read_data[19:15]), .rs2(read_data[24:20]), .value1(value1), .value2(value2),
    .write(~trap & (state == EXECUTE & writes | state == MEMORY & load) & instruction[11:7] != 0), .rd(instruction[11:7]),
    .data(load ? loaded : lui ? immediate : auipc ? sum : jal | jalr ? following : result)
  );

  // it also begins without a reset
  initial begin
    state = FETCH;
    pc = START;
    trap = 0;
    instruction = 0;
    {a, b, immediate} = 0;
    {load, store, branch, jal, jalr, lui, auipc, by_immediate, by_register} = 0;
  end
  always @(posedge clk)
    if (rst) begin
      state <= FETCH;
      pc <= START;
      trap <= 0;
      instruction <= 0;
      {a, b, immediate} <= 0;
      {load, store, branch, jal, jalr, lui, auipc, by_immediate, by_register} <= 0;
    end else if (fault) trap <= 1;
    else if (!trap)
      case (state)
        FETCH: state <= DECODE;
        DECODE: begin
          instruction <= read_data;
          a <= value1;
          b <= value2;
          immediate <= its_immediate;
          {load, store, branch, jal, jalr, lui, auipc, by_immediate, by_register} <= {
            is_load, is_store, is_branch, is_jal, is_jalr, is_lui, is_auipc, is_by_immediate, is_by_register};
          state <= EXECUTE;
        end
        EXECUTE: begin
          pc <= next;
          state <= access ? MEMORY : DECODE;
        end
        MEMORY: state <= DECODE;
      endcase
endmodule

// A word of memory in the cycle after its address; a cycle that writes leaves `read_data` as it is.
module ram #(parameter PROGRAM = "program.hex", parameter BITS = 12) (
  input clk,
  input enable,
  input [BITS-1:0] address,
  input [31:0] write_data,
  input [3:0] write_mask,
  output reg [31:0] read_data
);
  reg [31:0] words [0:(1<<BITS)-1];
  initial $readmemh(PROGRAM, words);
  always @(posedge clk)
    if (enable) begin
      if (write_mask == 0) read_data <= words[address];
      if (write_mask[0]) words[address][7:0] <= write_data[7:0];
      if (write_mask[1]) words[address][15:8] <= write_data[15:8];
      if (write_mask[2]) words[address][23:16] <= write_data[23:16];
      if (write_mask[3]) words[address][31:24] <= write_data[31:24];
    end
endmodule

module cpu #(parameter PROGRAM = "program.hex") (
  input clk,
  input rst,
  output reg put,          // the output port: a character in this cycle
  output reg [7:0] character,
  output reg done,
  output reg [31:0] status,
  output trap
);
  wire request;
  wire [31:0] address, write_data, word;
  wire [3:0] write_mask;
  wire outside = address[31:14] != 0;
  reg reads_cycles;
  reg [31:0] cycles;

  core core (
    .clk(clk), .rst(rst), .request(request), .address(address), .write_data(write_data), .write_mask(write_mask),
    .read_data(reads_cycles ? cycles : word), .trap(trap)
  );
  ram #(.PROGRAM(PROGRAM)) ram (
    .clk(clk), .enable(request & ~outside), .address(address[13:2]), .write_data(write_data), .write_mask(write_mask),
    .read_data(word)
  );

  wire port = request & address[31:28] == 4'd1 & write_mask != 0;
  initial {put, character, done, status, cycles, reads_cycles} = 0;
  always @(posedge clk)
    if (rst) begin
      put <= 0;
      character <= 0;
      done <= 0;
      status <= 0;
      cycles <= 0;
      reads_cycles <= 0;
    end else begin
      cycles <= cycles + 1;
      put <= port & ~address[2];
      if (port & ~address[2]) character <= write_data[7:0];
      if (port & address[2]) begin
        done <= 1;
        status <= write_data;
      end
      if (request) reads_cycles <= outside;
    end
endmodule
