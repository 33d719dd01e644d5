//! The examples, run: what is shown works.

#[path = "../../examples/checkpoint.rs"]
mod checkpoint;
#[path = "../../examples/hardware_test.rs"]
mod hardware_test;
#[path = "../../examples/lfsr.rs"]
mod lfsr;
#[path = "../../examples/lockstep.rs"]
mod lockstep;

#[test]
fn a_pool_of_threads_runs_one_netlist() {
    lfsr::main().unwrap();
}

#[test]
fn a_run_is_replayed_from_a_checkpoint() {
    checkpoint::main().unwrap();
}

#[test]
fn two_circuits_run_in_lockstep() {
    lockstep::main().unwrap();
}
