//! Pictures: the path that was drawn over the curve that it was to follow, and beneath it how far it was off, as SVG.
//!
//! A [`Recording`] takes the points as they come and keeps no more than a picture can show; a [`Picture`] makes a
//! self-contained SVG of it: light or dark as the viewer's system is, the same bytes on every machine. This room knows
//! points and curves; it knows nothing of engines, waveforms or the command line.

pub(crate) mod axis;
pub(crate) mod frame;
mod picture;
mod recording;

pub use picture::Picture;
pub use recording::Recording;
