//! What other tools say: Icarus Verilog, Yosys, Verilator, GTKWave, Graphviz, Chromium. Where one is missing its tests are
//! ignored, with the reason.

#[path = "../support/mod.rs"]
mod support;

mod campaign_export;
mod designs;
mod elements;
mod export_elements;
mod export_verilog;
mod export_yosys;
mod feed_icarus;
mod force;
mod formal;
mod pictures;
mod prints;
mod replay_order;
mod start;
mod stimulus;
mod suites;
mod verilog;
mod view;
mod why;
mod yosys;
mod yosys_cells;
mod yosys_memory;
