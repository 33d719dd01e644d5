//! The documents' interpolation algorithms, step by step, in plain integers.
//!
//! Each is written from the points of the program that its document lists and is an [`Interpolator`], an iterator over
//! clocks. This room knows nothing of circuits, engines or waveforms: what the circuits do is compared with what is
//! computed here. [`Request`] is the front door: any method, from point to point, with its options.
//!
//! The sources are lecture notes, cited as *document A* (differential increments), *B* and *C* (evaluation function).

pub mod clock;
pub mod dda;
pub mod evaluation;
pub mod feed;
pub mod ideal;
pub mod input;
pub mod method;
pub mod offset;
pub mod quadrant;
pub mod request;

pub use clock::{Clock, Columns, Interpolator, Packing, Stopped, Watchdog};
pub use dda::circle::{DdaCircle, DdaCirclePrinted};
pub use dda::conic::{Course, CurveInput};
pub use dda::curve::{DdaCurve, Printed};
pub use dda::line::{DdaLine, DdaLinePrinted};
pub use dda::line_3d::DdaLine3d;
pub use evaluation::circle::{EfCircle, EfCirclePrinted};
pub use evaluation::fast_circle::{EfCircleFast, EfCircleFastPrinted};
pub use evaluation::fast_line::{EfLineFast, EfLineFastPrinted};
pub use evaluation::karibsky::{Karibsky, KaribskyPrinted};
pub use evaluation::line::{EfLine, EfLinePrinted};
pub use evaluation::line_3d::EfLine3d;
pub use ideal::Ideal;
pub use input::{ArcInput, InputError, Line3dInput, LineInput};
pub use method::{Method, Shape, UnknownMethod};
pub use offset::{Offset, OffsetArc, OffsetLine, Side, UnknownSide};
pub use quadrant::{ArcPath, Mirrored, Quadrants};
pub use request::{Drawing, Options, Request};

/// The widest coordinate register, bits.
pub const MAX_BITS: u32 = 32;
