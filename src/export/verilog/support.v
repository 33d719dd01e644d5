// A register that takes data while a load, set or reset is active, whatever its clock does; the data may change
// meanwhile. An x at a control counts as inactive; one that comes after a 0 samples as the clock does.
module discreta_register #(
    parameter WIDTH = 1,
    parameter [0:0] FALLING = 1'b0,
    parameter [WIDTH-1:0] SET_VALUE = {WIDTH{1'b1}},
    parameter [WIDTH-1:0] RESET_VALUE = {WIDTH{1'b0}},
    parameter [WIDTH-1:0] INIT = {WIDTH{1'bx}}
) (
    input  wire clk,
    input  wire [WIDTH-1:0] d,
    input  wire async_load,
    input  wire async_set,
    input  wire async_reset,
    input  wire en,
    input  wire sync_set,
    input  wire sync_reset,
    output wire [WIDTH-1:0] q
);
    wire clock = clk ^ FALLING;
`ifdef YOSYS
    wire [WIDTH-1:0] loaded = async_reset ? RESET_VALUE : async_set ? SET_VALUE : d;
    wire at_once = async_reset | async_set | async_load;
    wire [WIDTH-1:0] next = sync_reset ? RESET_VALUE : sync_set ? SET_VALUE : en ? d : q;
    // made of a latch for what is loaded, flip-flops for what is clocked, and one that tells which came last
    reg [WIDTH-1:0] held, clocked;
    reg last;
    initial {held, clocked, last} = {INIT, INIT, 1'b1};
    always @* if (at_once) held = loaded;
    always @(posedge clock) clocked <= next;
    always @(posedge clock or posedge at_once) if (at_once) last <= 1'b0; else last <= 1'b1;
    assign q = last ? clocked : held;
`else
    /* verilator lint_off MULTIDRIVEN */ // both blocks give the same while a control is active
    /* verilator lint_off SYNCASYNCNET */
    reg [WIDTH-1:0] state;
    wire started;
    discreta_started start (.started(started));
    assign q = state;
    initial state = INIT;
    always @(posedge clock or posedge async_load or posedge async_set or posedge async_reset)
        if (async_reset) state <= RESET_VALUE;
        else if (async_set) state <= SET_VALUE;
        else if (async_load) state <= d;
        else if (!started) state <= state;
        else if (sync_reset) state <= RESET_VALUE;
        else if (sync_set) state <= SET_VALUE;
        else if (en) state <= d;
`ifndef SYNTHESIS
    always @(d or async_load or async_set or async_reset)
        if (async_reset) state <= RESET_VALUE;
        else if (async_set) state <= SET_VALUE;
        else if (async_load) state <= d;
`endif
    /* verilator lint_on SYNCASYNCNET */
    /* verilator lint_on MULTIDRIVEN */
`endif
endmodule


// A flip-flop whose set, reset and load act when they become active, as an always block does that waits for them.
module discreta_edge_register #(
    parameter WIDTH = 1,
    parameter [0:0] FALLING = 1'b0,
    parameter [WIDTH-1:0] SET_VALUE = {WIDTH{1'b1}},
    parameter [WIDTH-1:0] RESET_VALUE = {WIDTH{1'b0}},
    parameter [WIDTH-1:0] INIT = {WIDTH{1'bx}}
) (
    input  wire clk,
    input  wire [WIDTH-1:0] d,
    input  wire [WIDTH-1:0] load_data,
    input  wire async_load,
    input  wire async_set,
    input  wire async_reset,
    input  wire en,
    output wire [WIDTH-1:0] q
);
    wire clock = clk ^ FALLING;
    reg [WIDTH-1:0] state;
    wire started;
    discreta_started start (.started(started));
    assign q = state;
    initial state = INIT;
    always @(posedge clock or posedge async_load or posedge async_set or posedge async_reset)
        if (async_reset) state <= RESET_VALUE;
        else if (async_set) state <= SET_VALUE;
        else if (async_load) state <= load_data;
        else if (!started) state <= state;
        else if (en) state <= d;
endmodule


// A counter that takes data while its load is active, whatever its clock does; the data may change meanwhile.
module discreta_counter #(
    parameter WIDTH = 1,
    parameter [0:0] FALLING = 1'b0,
    parameter [WIDTH-1:0] STEP = 1,
    parameter [WIDTH-1:0] INIT = {WIDTH{1'bx}}
) (
    input  wire clk,
    input  wire [WIDTH-1:0] d,
    input  wire async_load,
    input  wire async_reset,
    input  wire en,
    input  wire down,
    input  wire load,
    output wire [WIDTH-1:0] q
);
    /* verilator lint_off WIDTH */ // one bit added to many
    wire [WIDTH-1:0] count = q + ({WIDTH{down}} ^ STEP) + down;
    /* verilator lint_on WIDTH */
    wire clock = clk ^ FALLING;
`ifdef YOSYS
    wire [WIDTH-1:0] loaded = async_reset ? {WIDTH{1'b0}} : d;
    wire at_once = async_reset | async_load;
    wire [WIDTH-1:0] next = load ? d : en ? count : q;
    // made of a latch for what is loaded, flip-flops for what is clocked, and one that tells which came last
    reg [WIDTH-1:0] held, clocked;
    reg last;
    initial {held, clocked, last} = {INIT, INIT, 1'b1};
    always @* if (at_once) held = loaded;
    always @(posedge clock) clocked <= next;
    always @(posedge clock or posedge at_once) if (at_once) last <= 1'b0; else last <= 1'b1;
    assign q = last ? clocked : held;
`else
    /* verilator lint_off MULTIDRIVEN */ // both blocks give the same while a control is active
    /* verilator lint_off SYNCASYNCNET */
    reg [WIDTH-1:0] state;
    wire started;
    discreta_started start (.started(started));
    assign q = state;
    initial state = INIT;
    always @(posedge clock or posedge async_load or posedge async_reset)
        if (async_reset) state <= {WIDTH{1'b0}};
        else if (async_load) state <= d;
        else if (!started) state <= state;
        else if (load) state <= d;
        else if (en) state <= count;
`ifndef SYNTHESIS
    always @(d or async_load or async_reset)
        if (async_reset) state <= {WIDTH{1'b0}};
        else if (async_load) state <= d;
`endif
    /* verilator lint_on SYNCASYNCNET */
    /* verilator lint_on MULTIDRIVEN */
`endif
endmodule


// Its input, so many ticks later. Synthesis and Verilator make a wire of it.
module discreta_delay #(
    parameter WIDTH = 1,
    /* verilator lint_off UNUSED */ // of no use without delays
    parameter [63:0] TICKS = 1,
    parameter [WIDTH-1:0] INIT = {WIDTH{1'bx}}
    /* verilator lint_on UNUSED */
) (
    input  wire [WIDTH-1:0] a,
    output wire [WIDTH-1:0] q
);
`ifdef SYNTHESIS
    assign q = a;
`elsif VERILATOR
    assign q = a;
`else
    reg [WIDTH-1:0] late;
    assign q = late;
    initial begin
        late = INIT;
        late <= #TICKS a;
    end
    always @(a) late <= #TICKS a;
`endif
endmodule


// A node that relaxes exponentially towards its input, with a threshold behind it. While the input is or was unknown it
// is followed by the lowest and the highest voltage that it may have. Synthesis and Verilator make a wire of it.
module discreta_rc_delay #(
    // real numbers as their bits
    /* verilator lint_off UNUSED */ // of no use without delays
    parameter [63:0] TAU_BITS = 64'h3ff0000000000000,
    parameter [63:0] RISE_BITS = 64'h3fe0000000000000,
    parameter [63:0] FALL_BITS = 64'h3fe0000000000000
    /* verilator lint_on UNUSED */
) (
    input  wire a,
    output wire q
);
`ifdef SYNTHESIS
    assign q = a;
`elsif VERILATOR
    assign q = a;
`else
    real TAU, RISE, FALL, low_volts, high_volts, passed;
    reg low_goal, high_goal, low, high, low_due, high_due, low_start, high_start, y;
    reg [63:0] since, low_ticks, high_ticks;
    assign q = y;
    initial begin
        TAU = $bitstoreal(TAU_BITS); RISE = $bitstoreal(RISE_BITS); FALL = $bitstoreal(FALL_BITS);
        low_volts = 0.0; high_volts = 1.0; since = 0;
        low_goal = 0; high_goal = 1; low = 0; high = 1; low_start = 0; high_start = 0;
        y = 1'bx;
        #0 drive;
    end
    // the ticks until the threshold is reached
    function [63:0] ticks(input goal, input real volts);
        real exact;
        begin
            exact = TAU * $ln(goal ? (1.0 - volts) / (1.0 - RISE) : volts / FALL);
            ticks = exact <= 1.0 ? 64'd1 : $rtoi(exact) + ($itor($rtoi(exact)) < exact ? 64'd1 : 64'd0);
        end
    endfunction
    task drive;
        begin
            passed = ($time - since) / TAU;
            low_volts = low_goal + (low_volts - low_goal) * $exp(-passed);
            high_volts = high_goal + (high_volts - high_goal) * $exp(-passed);
            since = $time;
            low_goal = a === 1'b1;
            high_goal = a !== 1'b0;
            low_due = low_goal !== low;
            high_due = high_goal !== high;
            if (low_due) low_ticks = ticks(low_goal, low_volts);
            if (high_due) high_ticks = ticks(high_goal, high_volts);
            disable low_wait;
            disable high_wait;
            low_start <= ~low_start;
            high_start <= ~high_start;
        end
    endtask
    always @(a) drive;
    always @(low_start) begin : low_wait
        if (low_due) begin
            #(low_ticks) low = low_goal;
            y <= low === high ? low : 1'bx;
        end
    end
    always @(high_start) begin : high_wait
        if (high_due) begin
            #(high_ticks) high = high_goal;
            y <= low === high ? high : 1'bx;
        end
    end
`endif
endmodule


// 1 once the circuit has first settled. What nets become until then is no edge.
module discreta_started #(
    /* verilator lint_off UNUSED */ // of no use where nothing settles
    parameter ROUNDS = 4
    /* verilator lint_on UNUSED */
) (
    output wire started
);
`ifdef SYNTHESIS
    assign started = 1'b1;
`elsif VERILATOR
    assign started = 1'b1;
`else
    reg done = 1'b0, round = 1'b0;
    assign started = done;
    initial begin
        #0;
        repeat (ROUNDS) begin
            round <= ~round;
            @(round);
        end
        done = 1'b1;
    end
`endif
endmodule


// A free-running clock: 0 before tick PHASE, then HIGH ticks 1 in each PERIOD. Synthesis and Verilator need one from outside.
module discreta_clock #(
    /* verilator lint_off UNUSED */ // of no use without delays
    parameter [63:0] PERIOD = 2,
    parameter [63:0] HIGH = 1,
    parameter [63:0] PHASE = 0,
    // its first value is a change: it is a level, not a clock
    parameter LEVEL = 0
    /* verilator lint_on UNUSED */
) (
    output wire q
);
`ifdef SYNTHESIS
    assign q = 1'b0;
`elsif VERILATOR
    assign q = 1'b0;
`else
    reg level;
    assign q = level;
    initial begin
        if (LEVEL) #0;
        level = PHASE == 0;
        #PHASE;
        forever begin
            level <= 1'b1;
            #HIGH level <= 1'b0;
            #(PERIOD - HIGH);
        end
    end
`endif
endmodule


// A wire that closes a circle of gates.
module discreta_feedback #(
    parameter WIDTH = 1
) (
    input  wire [WIDTH-1:0] a,
    output wire [WIDTH-1:0] q
);
    assign q = a;
endmodule
