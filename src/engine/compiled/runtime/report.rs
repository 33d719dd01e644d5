//! How a run went, for `-v`.

use std::fmt;

/// How a run went, in the compiled engine's own terms.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct EngineReport {
    /// Phases in which all state and inputs were known.
    pub known: u64,
    /// Phases in which some state was taken to be unknown, and the rest to be known.
    pub mixed: u64,
    /// Phases in the four-valued variant.
    pub four_valued: u64,
    /// How many variants were compiled.
    pub variants: u64,
    /// Phases that ran as straight code.
    pub straight: u64,
    /// How many times straight code has bailed out.
    pub bail_outs: u64,
    /// How many times state was unknown against the assumption of the variant that ran.
    pub guards: u64,
    /// Phases that ran on state packed into words.
    pub packed: u64,
}

impl EngineReport {
    /// How many phases there were.
    #[must_use]
    pub fn phases(&self) -> u64 {
        self.known + self.mixed + self.four_valued
    }
}

impl fmt::Display for EngineReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let EngineReport { known, mixed, four_valued, straight, variants, bail_outs, guards, .. } = *self;
        write!(f, "engine compiled, {} evaluation phases: {known} all known, ", self.phases())?;
        if mixed > 0 {
            write!(f, "{mixed} with some unknown, ")?;
        }
        write!(f, "{four_valued} four-valued; {straight} in straight code")?;
        if bail_outs + guards > 0 {
            write!(f, ", left {} times; {variants} variants", bail_outs + guards)?;
        }
        Ok(())
    }
}
