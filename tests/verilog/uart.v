// A serial line: a transmitter and a receiver that samples eight times a bit and votes, with start, 8 data, parity and
// stop bits. `noise` turns the line over between the two.

module strobe #(parameter DIVIDE = 3) (input clk, input rst, output reg now);
  localparam BITS = $clog2(DIVIDE);
  reg [BITS-1:0] count;
  always @(posedge clk)
    if (rst) {count, now} <= 0;
    else begin
      now <= count == DIVIDE - 1;
      count <= count == DIVIDE - 1 ? 0 : count + 1;
    end
endmodule

module transmitter #(parameter ODD = 0) (
  input clk, input rst, input sample, input send, input [7:0] data, output reg line, output busy
);
  localparam IDLE = 3'd0, START = 3'd1, DATA = 3'd2, PARITY = 3'd3, STOP = 3'd4;
  reg [2:0] state, eighth, bit_number;
  reg [7:0] shift;
  reg parity;
  assign busy = state != IDLE;
  always @(posedge clk)
    if (rst) begin
      state <= IDLE;
      line <= 1;
      {eighth, bit_number, shift, parity} <= 0;
    end else if (state == IDLE) begin
      if (send) begin
        shift <= data;
        parity <= ^data ^ ODD;
        {eighth, bit_number} <= 0;
        state <= START;
      end
    end else if (sample) begin
      eighth <= eighth + 1;
      case (state)
        START: line <= 0;
        DATA: line <= shift[0];
        PARITY: line <= parity;
        STOP: line <= 1;
      endcase
      if (&eighth)
        case (state)
          START: state <= DATA;
          DATA: begin
            shift <= shift >> 1;
            bit_number <= bit_number + 1;
            if (&bit_number) state <= PARITY;
          end
          PARITY: state <= STOP;
          default: state <= IDLE;
        endcase
    end
endmodule

module receiver #(parameter ODD = 0) (
  input clk, input rst, input sample, input line,
  output reg [7:0] data, output reg valid, output reg wrong_parity, output reg wrong_stop
);
  function vote(input [2:0] samples);
    vote = (samples[0] & samples[1]) | (samples[1] & samples[2]) | (samples[0] & samples[2]);
  endfunction

  reg [1:0] meta;          // brings the line to this clock
  reg [2:0] seen, eighth;
  reg [3:0] got;           // bits: 0 to 7 data, 8 parity, 9 stop
  reg active, started;
  wire value = vote(seen);
  always @(posedge clk)
    if (rst) begin
      {meta, seen} <= {5{1'b1}};
      {eighth, got, active, started, data, valid, wrong_parity, wrong_stop} <= 0;
    end else begin
      meta <= {meta[0], line};
      valid <= 0;
      if (sample) begin
        seen <= {seen[1:0], meta[1]};
        eighth <= eighth + 1;
        if (!active) begin
          if (!meta[1]) begin
            active <= 1;
            started <= 0;
            eighth <= 0;
            got <= 0;
          end
        end else if (eighth == 3'd4)
          casez ({started, got})
            5'b0_????:
              if (value) active <= 0;
              else started <= 1;
            5'b1_0???: begin
              data <= {value, data[7:1]};
              got <= got + 1;
            end
            5'b1_1000: begin
              wrong_parity <= value != (^data ^ ODD);
              got <= got + 1;
            end
            default: begin
              wrong_stop <= !value;
              valid <= 1;
              active <= 0;
            end
          endcase
      end
    end
endmodule

module uart (
  input clk, input rst, input send, input [7:0] data, input noise,
  output busy, output line, output [7:0] received, output valid, output wrong_parity, output wrong_stop,
  output reg [7:0] count
);
  wire sample;
  strobe #(.DIVIDE(3)) strobe (.clk(clk), .rst(rst), .now(sample));
  transmitter #(.ODD(1)) transmitter (
    .clk(clk), .rst(rst), .sample(sample), .send(send), .data(data), .line(line), .busy(busy));
  receiver #(.ODD(1)) receiver (
    .clk(clk), .rst(rst), .sample(sample), .line(line ^ noise), .data(received), .valid(valid),
    .wrong_parity(wrong_parity), .wrong_stop(wrong_stop));
  always @(posedge clk)
    if (rst) count <= 0;
    else if (valid & ~wrong_parity & ~wrong_stop) count <= count + 1;
endmodule
