//! What is compared: each method, with the options that change what it draws.

use std::path::{Path, PathBuf};

use crate::interpolate::{Method, Options, Request};

/// A method with its options.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Variant {
    /// The method.
    pub method: Method,
    /// How it works.
    pub options: Options,
}

impl Variant {
    /// A method as it is by default.
    #[must_use]
    pub const fn of(method: Method) -> Variant {
        Variant { method, options: Request::new(method, [0; 3]).options }
    }

    const fn centred(method: Method) -> Variant {
        let mut variant = Variant::of(method);
        variant.options.centred = true;
        variant
    }

    const fn dda(method: Method, parallel: bool, half_preload: bool) -> Variant {
        let mut variant = Variant::of(method);
        variant.options.parallel = parallel;
        variant.options.half_preload = half_preload;
        variant
    }

    const fn normalised(method: Method) -> Variant {
        let mut variant = Variant::of(method);
        variant.options.normalise = true;
        variant
    }

    /// Lines in the plane.
    pub const LINES: &'static [Variant] = &[
        Variant::of(Method::EfLine),
        Variant::centred(Method::EfLine),
        Variant::of(Method::EfLineFast),
        Variant::centred(Method::EfLineFast),
        Variant::of(Method::DdaLine),
        Variant::dda(Method::DdaLine, false, true),
        Variant::normalised(Method::DdaLine),
    ];

    /// Arcs.
    pub const ARCS: &'static [Variant] = &[
        Variant::of(Method::Grossman),
        Variant::of(Method::Karibsky),
        Variant::of(Method::EfCircleFast),
        Variant::of(Method::DdaCircle),
        Variant::dda(Method::DdaCircle, false, true),
        Variant::dda(Method::DdaCircle, true, false),
        Variant::dda(Method::DdaCircle, true, true),
        Variant::normalised(Method::DdaCircle),
    ];

    /// Curves of the second order.
    pub const CURVES: &'static [Variant] = &[
        Variant::of(Method::DdaCurve),
        Variant::dda(Method::DdaCurve, false, true),
        Variant::dda(Method::DdaCurve, true, false),
        Variant::dda(Method::DdaCurve, true, true),
    ];

    /// Lines in space.
    pub const SPACE: &'static [Variant] = &[
        Variant::of(Method::EfLine3d),
        Variant::centred(Method::EfLine3d),
        Variant::of(Method::DdaLine3d),
        Variant::dda(Method::DdaLine3d, false, true),
    ];

    /// Its name: the method, and the options as on the command line.
    #[must_use]
    pub fn name(&self) -> String {
        let mut name = match self.method {
            // one method under two names
            Method::Grossman | Method::EfCircle => "grossman (ef-circle)".to_owned(),
            method => method.to_string(),
        };
        let Options { parallel, half_preload, normalise, centred, .. } = self.options;
        for (set, option) in [
            (parallel, " --parallel"),
            (half_preload, " --half-preload"),
            (normalise, " --normalise"),
            (centred, " --centred"),
        ] {
            if set {
                name += option;
            }
        }
        name
    }

    /// Whether the carries of accumulators are the steps.
    #[must_use]
    pub const fn is_dda(&self) -> bool {
        matches!(self.method, Method::DdaLine | Method::DdaCircle | Method::DdaCurve | Method::DdaLine3d)
    }
}

/// The circuit of a method in a folder of circuits: at register level, and of gates alone.
#[must_use]
pub fn circuits(folder: &Path, method: Method) -> [PathBuf; 2] {
    let name = match method {
        Method::EfLine => "evaluation/line",
        Method::EfCircle | Method::Grossman => "evaluation/circle",
        Method::EfLineFast => "evaluation/fast_line",
        Method::EfCircleFast => "evaluation/fast_circle",
        Method::Karibsky => "evaluation/karibsky",
        Method::DdaLine => "dda/line",
        Method::DdaCircle => "dda/circle",
        Method::DdaCurve => "dda/curve",
        Method::EfLine3d => "three_axis/line",
        Method::DdaLine3d => "three_axis/dda_line",
    };
    ["", "_gates"].map(|form| folder.join(format!("{name}{form}.json")))
}
