//! What a user meets: commands, messages, documentation, golden traces. The answer that a developer waits for:
//! `cargo test --test quick`.

#[path = "../support/mod.rs"]
mod support;

mod bad;
mod built_in;
mod cli;
mod cli_diff;
mod cli_interpolate;
mod cli_stats;
mod compare;
mod diff_options;
mod docs;
mod draw;
mod examples;
mod given;
mod hierarchy;
mod machine;
mod outputs;
mod plot;
mod readme;
mod rooms;
mod run_options;
mod save;
mod simulator;
mod stats;
mod traces;
mod verilog;
mod wave_text;
