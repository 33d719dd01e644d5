//! The pins of every kind of cell: their names, what they are to the cell, and their numbers as constants.
//!
//! A module here is one shape of pins; `IN`, `D` and the like are the places of its input pins, `PINS` is the list of
//! them. Nothing outside writes the number of a pin.

/// What an input pin is to its cell.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// Its change can change an output at once.
    Data,
    /// Read only at a clock edge.
    Sampled,
    /// The clock.
    Clock,
    /// A control that acts at once: set, reset, asynchronous load, enable of a latch.
    Level,
    /// A control that is read at the clock edge.
    Enable,
    /// A control that acts when it becomes active, as the clock does at its rising edge.
    Trigger,
    /// The input of a delay: its change changes an output later.
    Delayed,
}

/// An input pin.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pin {
    /// The name.
    pub name: &'static str,
    /// What it is to its cell.
    pub role: Role,
    /// Whether it must be connected.
    pub required: bool,
    /// What it reads when it is not connected, in every bit.
    pub default: bool,
}

/// A module for each shape: the pins as constants, numbered in order, and the list of them.
macro_rules! shapes {
    ($($(#[$doc:meta])* $shape:ident { $($number:ident = $name:literal: $role:ident $($open:ident)?),* $(,)? })*) => {
        $($(#[$doc])* pub mod $shape {
            #![allow(missing_docs, unused_imports, dead_code)]
            use super::{Pin, Role};

            #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
            enum Number { $($number),* }
            $(pub const $number: usize = Number::$number as usize;)*
            /// The pins in order.
            pub const PINS: &[Pin] =
                &[$(shapes!(@pin $name $role $($open)?)),*];
        })*
    };
    // what it reads unconnected: nothing, if it has to be connected
    (@pin $name:literal $role:ident) => { Pin { name: $name, role: Role::$role, required: true, default: false } };
    (@pin $name:literal $role:ident low) => { Pin { name: $name, role: Role::$role, required: false, default: false } };
    (@pin $name:literal $role:ident high) => { Pin { name: $name, role: Role::$role, required: false, default: true } };
}

shapes! {
    /// One operand.
    unary { A = "a": Data }
    /// Two operands.
    binary { A = "a": Data, B = "b": Data }
    /// Three operands.
    ternary { A = "a": Data, B = "b": Data, C = "c": Data }
    /// Any number of inputs, in one vector.
    several { IN = "in": Data }
    /// AND-OR multiplexer.
    and_or { IN = "in": Data, SEL = "sel": Data }
    /// Multiplexer with a binary select.
    mux { IN = "in": Data, S = "s": Data }
    /// Tri-state buffer.
    tristate { A = "a": Data, EN = "en": Data }
    /// Full adder.
    full_adder { A = "a": Data, B = "b": Data, CI = "ci": Data }
    /// Adder.
    add { A = "a": Data, B = "b": Data, CI = "ci": Data low }
    /// Subtractor.
    sub { A = "a": Data, B = "b": Data, BI = "bi": Data low }
    /// Adder and subtractor, chosen by an input.
    add_sub { A = "a": Data, B = "b": Data, CI = "ci": Data low, SUB = "sub": Data }
    /// Multiplexers with a line for each input, or a select for each bit.
    chosen { A = "a": Data, B = "b": Data, S = "s": Data }
    /// Demultiplexer.
    demux { A = "a": Data, S = "s": Data }
    /// Carry chain.
    carry { P = "p": Data, G = "g": Data, CI = "ci": Data }
    /// Adder with all its carries.
    alu { A = "a": Data, B = "b": Data, CI = "ci": Data, BI = "bi": Data }
    /// SR flip-flop.
    sr { S = "s": Level, R = "r": Level }
    /// D flip-flop.
    flop {
        CLK = "clk": Clock,
        D = "d": Data,
        ALOAD = "aload": Level low,
        SET = "set": Level low,
        RESET = "reset": Level low,
        EN = "en": Enable high,
        SYNC_SET = "sync_set": Enable low,
        SYNC_RESET = "sync_reset": Enable low,
    }
    /// D flip-flop whose asynchronous controls act at their edges.
    edge_flop {
        CLK = "clk": Clock,
        D = "d": Sampled,
        AD = "ad": Sampled low,
        ALOAD = "aload": Trigger low,
        SET = "set": Trigger low,
        RESET = "reset": Trigger low,
        EN = "en": Enable high,
    }
    /// Transparent latch.
    latch { EN = "en": Level, D = "d": Data, SET = "set": Level low, RESET = "reset": Level low }
    /// Counter.
    counter {
        CLK = "clk": Clock,
        D = "d": Data low,
        ALOAD = "aload": Level low,
        RESET = "reset": Level low,
        EN = "en": Enable high,
        DOWN = "down": Sampled low,
        LOAD = "load": Enable low,
    }
    /// Accumulator.
    accumulator { CLK = "clk": Clock, D = "d": Data, CI = "ci": Data low, RESET = "reset": Level low, EN = "en": Enable high }
    /// Memory; each pin is that of all ports.
    memory {
        RD_CLK = "rd_clk": Clock,
        RD_EN = "rd_en": Enable high,
        RD_ARST = "rd_arst": Level low,
        RD_SRST = "rd_srst": Enable low,
        RD_ADDR = "rd_addr": Data,
        WR_CLK = "wr_clk": Clock,
        WR_EN = "wr_en": Enable,
        WR_ADDR = "wr_addr": Data,
        WR_DATA = "wr_data": Data,
    }
    /// Delays.
    delay { A = "a": Delayed }
    /// What has no inputs.
    none {}
}
