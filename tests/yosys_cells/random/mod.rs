//! Random netlists.
mod compare;
mod design;
mod generate;
mod shrink;

use crate::support::folder;
use compare::compare;
use generate::generate;
use needs::needs;

#[needs(iverilog, yosys)]
#[test]
fn random_netlists() {
    let from: u64 = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(0);
    let n: u64 = std::env::var("N").ok().and_then(|s| s.parse().ok()).unwrap_or(10);
    let begun = std::time::Instant::now();
    let designs: Vec<_> = (from..from + n).map(|s| generate(s, 80, 300)).collect();
    println!("{:?} generated", begun.elapsed());
    let o = compare(&folder("random"), &designs, "");
    println!("{:?} {} changes {} compared {} known", begun.elapsed(), o.changes, o.compared, o.known);
    for (d, o) in designs.iter().zip(&o.differences) {
        if let Some(o) = o {
            println!("seed {} {} items {} wires {:?}", d.seed, d.items.len(), d.wires.len(), o);
            let (d, o) = shrink::shrink(&folder("random_shrink"), d, o, "");
            let f = shrink::write(&folder("random"), &d, &o, "");
            println!("{:?} {}", begun.elapsed(), f.display());
        }
    }
}
