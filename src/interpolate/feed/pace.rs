//! How constant the "constant speed" is.

/// What the interval after a step of 0, 1, 2 and 3 axes is multiplied by: «1,41 пъти по-дълъг … 1,73 пъти по-дълъг».
const TIMES: [f64; 4] = [1.0, 1.0, 1.41, 1.73];

/// The mean speed over a path, where 1 is the commanded speed of one BLU an interval: its length in BLU over the time that
/// its clocks take, in intervals. `axes` has how many axes each clock steps; `constant`: the interval after a step of two
/// axes is 1.41, after three 1.73 times as long.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{EfLineFast, LineInput, feed::pace};
/// // XDXDXDX: 7 clocks along √(7² + 3²) = 7.616 BLU; with longer intervals 4 + 3·1.41 = 8.23
/// let axes = || EfLineFast::new(LineInput::new(7, 3)).unwrap().map(|clock| clock.axes());
/// assert_eq!(format!("{:.3}", pace(58f64.sqrt(), axes(), false)), "1.088");
/// assert_eq!(format!("{:.3}", pace(58f64.sqrt(), axes(), true)), "0.925");
/// ```
#[must_use]
pub fn pace(length: f64, axes: impl IntoIterator<Item = usize>, constant: bool) -> f64 {
    // counted first, so that the sum does not depend on the order
    let mut clocks = [0u64; 4];
    for n in axes {
        clocks[n.min(3)] += 1;
    }
    let time: f64 = clocks.iter().zip(TIMES).map(|(&n, times)| n as f64 * if constant { times } else { 1.0 }).sum();
    length / time
}
