//! The documents' comparison of methods (document C), measured: what a circuit is made of, and how it draws.
//!
//! [`Variant`] lists what is compared, [`Set`] what is drawn with it, [`Motion`] and [`Equipment`] what is measured, and
//! [`claims`] holds the documents' words against it. [`MEASURES`] defines every measure. This room knows circuits,
//! netlists and interpolators; it knows nothing of engines, waveforms or the command line, and prints nothing.

mod claims;
mod equipment;
mod measure;
mod motion;
mod report;
mod set;
mod variant;

pub use claims::{Claim, claims};
pub use equipment::Equipment;
pub use measure::measure;
pub use motion::{Motion, Watch};
pub use report::{Comparison, Group, Row};
pub use set::{Sample, Set, SetKind};
pub use variant::{Variant, circuits};

/// What each measure means.
pub const MEASURES: &[(&str, &str)] = &[
    (
        "gates",
        "AND, OR, NAND, NOR, XOR and XNOR gates of the all-gates circuit, those of n inputs counted as n − 1 of two \
         inputs; inverters apart. `discreta stats` says what counts as what.",
    ),
    ("flip-flops", "D flip-flops of the all-gates circuit, a bit each. SR flip-flops are gates there."),
    (
        "depth",
        "Gates on the longest way from a flip-flop or an input to a flip-flop or an output of the all-gates circuit: how \
         long a clock has to be.",
    ),
    ("adders", "Adders, subtractors and accumulators of the register-level circuit, and their bits together."),
    (
        "elements",
        "Cells of the register-level circuit: the boxes of the block diagram, and so how simple the method is.",
    ),
    ("clocks", "Pulses of Δt from START to КРАЙ: the mean over the set, and the most."),
    (
        "deviation",
        "Distance in BLU of the current point from the ideal curve after each clock: the most outside the circle or to \
         the left of the line (+), the most inside or to the right (−), and the mean without sign over all clocks. The \
         ideal arc goes through the start point. In space the distance has no sign.",
    ),
    (
        "speed",
        "Length drawn per clock, over the length a clock that was commanded: 1 BLU for methods by evaluation function, \
         L/2^p (lines) or R/2^p (arcs) for differential increments, whose Δt the speed block makes for it. Least and \
         greatest, and their ratio. Of lines of at least 2^(p−1) BLU each as a whole; of arcs with R ≥ 2^(p−1) by \
         direction, in 30 parts of 3°, all of them together.",
    ),
    (
        "×1.41",
        "The same when each interval after a step along two axes is 1.41 times as long, and 1.73 times after one along \
         three. For methods by evaluation function.",
    ),
    ("end", "Segments whose last point is exactly the end asked for; else the furthest that one is away."),
    (
        "F wrong",
        "Clocks after which F is not F(x, y): a wrong F is an error that would be carried on. Lines along y are left \
         out: there F(x, y) is 0 everywhere and tells nothing.",
    ),
];
