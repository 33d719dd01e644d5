//! Every element against sources other than its own code: Icarus Verilog, the tables of its documentation, and
//! arithmetic done here.

mod combinational;
mod documentation;
mod icarus;
mod storage;
mod time;

/// Every element is in one of the lists that the tests of this folder go through.
#[test]
fn no_element_is_left_out() {
    let mut tested: Vec<&str> = combinational::cases().chain(storage::cases()).map(|c| c.element).collect();
    tested.extend(time::ELEMENTS);
    for element in discreta::cell::elements() {
        assert!(tested.contains(&element.name), "no test covers `{}`", element.name);
    }
}
