//! What a waveform is about, said before it starts: timescale, scopes and variables.
//!
//! Plain data, checked once by [`Layout::check`]: a sink may then rely on every index and name.

use std::collections::HashSet;
use std::fmt;

use serde::Serialize;

/// A unit of time.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, PartialOrd, Ord, Serialize)]
pub enum TimeUnit {
    /// Femtosecond, 10⁻¹⁵ s.
    #[serde(rename = "fs")]
    Fs,
    /// Picosecond, 10⁻¹² s.
    #[serde(rename = "ps")]
    Ps,
    /// Nanosecond, 10⁻⁹ s.
    #[serde(rename = "ns")]
    Ns,
    /// Microsecond, 10⁻⁶ s.
    #[serde(rename = "us")]
    Us,
    /// Millisecond, 10⁻³ s.
    #[serde(rename = "ms")]
    Ms,
    /// Second.
    #[serde(rename = "s")]
    S,
}

impl TimeUnit {
    /// All units, the shortest first.
    pub const ALL: [TimeUnit; 6] = [TimeUnit::Fs, TimeUnit::Ps, TimeUnit::Ns, TimeUnit::Us, TimeUnit::Ms, TimeUnit::S];

    /// The power of ten of a second: -15 to 0.
    #[must_use]
    pub const fn exponent(self) -> i32 {
        match self {
            TimeUnit::Fs => -15,
            TimeUnit::Ps => -12,
            TimeUnit::Ns => -9,
            TimeUnit::Us => -6,
            TimeUnit::Ms => -3,
            TimeUnit::S => 0,
        }
    }

    /// How it is written: `fs` to `s`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            TimeUnit::Fs => "fs",
            TimeUnit::Ps => "ps",
            TimeUnit::Ns => "ns",
            TimeUnit::Us => "us",
            TimeUnit::Ms => "ms",
            TimeUnit::S => "s",
        }
    }
}

impl fmt::Display for TimeUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// How long one tick is: 1, 10 or 100 units.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Serialize)]
pub struct Timescale {
    /// 1, 10 or 100.
    pub count: u32,
    /// Of what.
    pub unit: TimeUnit,
}

impl Timescale {
    /// One nanosecond, the default of a circuit file.
    pub const NS: Timescale = Timescale { count: 1, unit: TimeUnit::Ns };

    /// A tick as a power of ten of a second, -15 to 2; none if the count is not 1, 10 or 100.
    #[must_use]
    pub const fn exponent(self) -> Option<i32> {
        match self.count {
            1 => Some(self.unit.exponent()),
            10 => Some(self.unit.exponent() + 1),
            100 => Some(self.unit.exponent() + 2),
            _ => None,
        }
    }

    /// The timescale whose tick is that power of ten of a second.
    #[must_use]
    pub fn from_exponent(exponent: i32) -> Option<Timescale> {
        let unit = TimeUnit::ALL.into_iter().rfind(|unit| unit.exponent() <= exponent)?;
        let count = 10_u32.checked_pow(exponent.abs_diff(unit.exponent()))?;
        (count <= 100).then_some(Timescale { count, unit })
    }

    /// A time in ticks with its unit, e.g. `1250 ns`.
    ///
    /// ```
    /// use discreta::wave::{TimeUnit, Timescale};
    /// assert_eq!(Timescale { count: 10, unit: TimeUnit::Ps }.time(125), "1250 ps");
    /// ```
    #[must_use]
    pub fn time(self, ticks: u64) -> String {
        format!("{} {}", u128::from(ticks) * u128::from(self.count), self.unit)
    }
}

impl fmt::Display for Timescale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.count, self.unit)
    }
}

/// What a scope stands for; viewers give each its own icon.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Default)]
pub enum ScopeKind {
    /// A module or an instance of one.
    #[default]
    Module,
    /// A group of cells inside a module, as Verilog's generate block.
    Block,
}

/// A scope.
#[derive(Clone, PartialEq, Eq, Debug, Hash)]
pub struct ScopeDecl {
    /// Its own name, e.g. `fa[3]`.
    pub name: String,
    /// The scope it stands in: an index below its own.
    pub parent: Option<usize>,
    /// What it stands for.
    pub kind: ScopeKind,
}

/// What a variable stands for; no effect on its values.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Default)]
pub enum VarKind {
    /// A net.
    #[default]
    Wire,
    /// The output of a storage cell.
    Reg,
    /// A number.
    Integer,
}

/// A variable.
#[derive(Clone, PartialEq, Eq, Debug, Hash)]
pub struct VarDecl {
    /// The scope it stands in, an index into [`Layout::scopes`].
    pub scope: usize,
    /// Its own name, without an index: a vector of width `w` is written `name [w-1:0]`.
    pub name: String,
    /// Bits, 1 to [`Layout::MAX_WIDTH`].
    pub width: u32,
    /// What it stands for.
    pub kind: VarKind,
    /// The variable of which this is another name: an index below its own, of the same width.
    pub alias_of: Option<usize>,
}

/// What a waveform is about.
///
/// ```
/// use discreta::wave::Layout;
/// let mut layout = Layout::default();
/// let top = layout.scope("line", None);
/// let adder = layout.scope("adder", Some(top));
/// let sum = layout.var(top, "sum", 8);
/// layout.alias(adder, "y", sum);
/// assert!(layout.check().is_ok());
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Layout {
    /// How long one tick is.
    pub timescale: Timescale,
    /// The scopes, each after its parent; siblings in the order in which a viewer lists them.
    pub scopes: Vec<ScopeDecl>,
    /// The variables, in the order in which a viewer lists those of one scope.
    pub vars: Vec<VarDecl>,
}

impl Default for Layout {
    fn default() -> Layout {
        Layout { timescale: Timescale::NS, scopes: Vec::new(), vars: Vec::new() }
    }
}

impl Layout {
    /// The widest variable, in bits: what readers keep in 31 bits with room to spare.
    pub const MAX_WIDTH: u32 = 1 << 24;

    /// Adds a module scope and returns its index.
    pub fn scope(&mut self, name: &str, parent: Option<usize>) -> usize {
        self.scopes.push(ScopeDecl { name: name.to_owned(), parent, kind: ScopeKind::Module });
        self.scopes.len() - 1
    }

    /// Adds a wire and returns its index.
    pub fn var(&mut self, scope: usize, name: &str, width: u32) -> usize {
        self.vars.push(VarDecl { scope, name: name.to_owned(), width, kind: VarKind::Wire, alias_of: None });
        self.vars.len() - 1
    }

    /// Adds another name for a variable and returns its index.
    ///
    /// # Panics
    /// If there is no variable `of`.
    pub fn alias(&mut self, scope: usize, name: &str, of: usize) -> usize {
        let VarDecl { width, kind, .. } = self.vars[of];
        self.vars.push(VarDecl { scope, name: name.to_owned(), width, kind, alias_of: Some(of) });
        self.vars.len() - 1
    }

    /// The variable that keeps the value of `var`: itself, or what it is in the end an alias of.
    ///
    /// # Panics
    /// If there is no such variable.
    #[must_use]
    pub fn origin(&self, mut var: usize) -> usize {
        while let Some(of) = self.vars[var].alias_of {
            var = of;
        }
        var
    }

    /// The full name of a scope, joined by dots.
    #[must_use]
    pub fn scope_path(&self, scope: usize) -> String {
        let mut names = Vec::new();
        let mut next = Some(scope);
        while let Some(decl) = next.and_then(|i| self.scopes.get(i)) {
            names.push(decl.name.as_str());
            next = decl.parent;
        }
        names.reverse();
        names.join(".")
    }

    /// Checks everything that a sink relies on.
    ///
    /// # Errors
    /// The first fault.
    pub fn check(&self) -> Result<(), LayoutError> {
        if self.timescale.exponent().is_none() {
            return Err(LayoutError::Timescale { count: self.timescale.count });
        }
        let mut seen = HashSet::new();
        for (i, scope) in self.scopes.iter().enumerate() {
            if scope.parent.is_some_and(|parent| parent >= i) {
                return Err(LayoutError::Index { what: "the parent of a scope", index: i });
            }
            let within = || scope.parent.map_or_else(String::new, |parent| self.scope_path(parent));
            check_name(&scope.name, within)?;
            if !seen.insert((scope.parent, scope.name.as_str())) {
                return Err(LayoutError::Twice { name: scope.name.clone(), scope: within() });
            }
        }
        let mut seen = HashSet::new();
        for (i, var) in self.vars.iter().enumerate() {
            if var.scope >= self.scopes.len() {
                return Err(LayoutError::Index { what: "the scope of a variable", index: i });
            }
            let within = || self.scope_path(var.scope);
            check_name(&var.name, within)?;
            if !seen.insert((var.scope, var.name.as_str())) {
                return Err(LayoutError::Twice { name: var.name.clone(), scope: within() });
            }
            if var.width == 0 || var.width > Layout::MAX_WIDTH {
                return Err(LayoutError::Width { name: format!("{}.{}", within(), var.name), width: var.width });
            }
            if let Some(of) = var.alias_of
                && (of >= i || self.vars[of].width != var.width)
            {
                return Err(LayoutError::Index { what: "an alias", index: i });
            }
        }
        Ok(())
    }
}

/// A name must stand as one word in a text file. `$end` ends a declaration for some readers even inside a word, and
/// nothing but a letter in front of an index is what all of them take for a name.
fn check_name(name: &str, within: impl Fn() -> String) -> Result<(), LayoutError> {
    let reason = if name.is_empty() {
        "it is empty"
    } else if name.chars().any(|c| c.is_whitespace() || c.is_control()) {
        "it has white space or a control character in it"
    } else if name.contains("$end") {
        "it has `$end` in it, which ends a declaration"
    } else if name.starts_with('[') {
        "it begins with an index"
    } else {
        return Ok(());
    };
    Err(LayoutError::Name { name: name.to_owned(), scope: within(), reason })
}

/// Why a [`Layout`] cannot be written.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum LayoutError {
    /// A name that no reader could tell from the text around it.
    Name {
        /// The name.
        name: String,
        /// The full name of the scope it stands in, empty at the top.
        scope: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A name that two scopes or two variables of one scope share.
    Twice {
        /// The name.
        name: String,
        /// The full name of the scope it stands in, empty at the top.
        scope: String,
    },
    /// A width that is 0 or above [`Layout::MAX_WIDTH`].
    Width {
        /// The full name of the variable.
        name: String,
        /// Its width in bits.
        width: u32,
    },
    /// An index that leads nowhere, or forward: the caller's mistake, not the user's.
    Index {
        /// What is wrong.
        what: &'static str,
        /// The scope or variable that has it.
        index: usize,
    },
    /// A timescale that is not 1, 10 or 100 of a unit.
    Timescale {
        /// What it is instead.
        count: u32,
    },
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |scope: &str| if scope.is_empty() { String::new() } else { format!(" in `{scope}`") };
        match self {
            LayoutError::Name { name, scope, reason } => {
                write!(f, "the name {name:?}{} cannot stand in a waveform: {reason}", place(scope))
            }
            LayoutError::Twice { name, scope } => write!(f, "the name `{name}` is given twice{}", place(scope)),
            LayoutError::Width { name, width } => {
                write!(f, "`{name}` is {width} bits wide; a waveform holds 1 to {}", Layout::MAX_WIDTH)
            }
            LayoutError::Index { what, index } => write!(f, "{what} (number {index}) leads nowhere"),
            LayoutError::Timescale { count } => write!(f, "a tick is 1, 10 or 100 of a unit, not {count}"),
        }
    }
}

impl std::error::Error for LayoutError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_var(name: &str) -> Layout {
        let mut layout = Layout::default();
        let top = layout.scope("top", None);
        layout.var(top, name, 1);
        layout
    }

    #[test]
    fn exponents_and_timescales_agree() {
        for exponent in -15..=2 {
            assert_eq!(Timescale::from_exponent(exponent).unwrap().exponent(), Some(exponent));
        }
        assert_eq!(Timescale::from_exponent(-16), None);
        assert_eq!(Timescale::from_exponent(3), None);
        assert_eq!(Timescale::from_exponent(-7), Some(Timescale { count: 100, unit: TimeUnit::Ns }));
    }

    #[test]
    fn names_that_break_a_file_are_refused() {
        for name in ["", "a b", "a\tb", "a\nb", "\u{7f}", "\u{a0}", "$end", "x$endy", "[3]"] {
            let error = with_var(name).check().unwrap_err();
            assert!(matches!(error, LayoutError::Name { .. }), "{name:?}: {error}");
        }
        for name in ["a", "fa[3]", "$procdff$12", "q_n", "größe", "a.b", "\\esc"] {
            assert_eq!(with_var(name).check(), Ok(()), "{name:?}");
        }
        let error = with_var("a b").check().unwrap_err().to_string();
        assert_eq!(
            error,
            "the name \"a b\" in `top` cannot stand in a waveform: it has white space or a control character in it"
        );
    }

    #[test]
    fn indices_widths_and_names_given_twice_are_refused() {
        let mut layout = with_var("a");
        layout.vars[0].width = 0;
        assert!(matches!(layout.check(), Err(LayoutError::Width { .. })));
        layout.vars[0].width = Layout::MAX_WIDTH + 1;
        assert!(matches!(layout.check(), Err(LayoutError::Width { .. })));
        layout.vars[0].width = Layout::MAX_WIDTH;
        assert_eq!(layout.check(), Ok(()));

        let mut layout = with_var("a");
        layout.alias(0, "a", 0);
        assert!(matches!(layout.check(), Err(LayoutError::Twice { .. })));
        layout.vars[1].name = "b".into();
        assert_eq!(layout.check(), Ok(()));
        layout.vars[1].width = 2;
        assert!(matches!(layout.check(), Err(LayoutError::Index { .. })));
        layout.vars[1].alias_of = Some(1);
        assert!(matches!(layout.check(), Err(LayoutError::Index { .. })));

        let mut layout = with_var("a");
        layout.scopes[0].parent = Some(0);
        assert!(matches!(layout.check(), Err(LayoutError::Index { .. })));
        layout.scopes[0].parent = None;
        layout.vars[0].scope = 1;
        assert!(matches!(layout.check(), Err(LayoutError::Index { .. })));
        layout.vars[0].scope = 0;
        layout.timescale.count = 5;
        assert_eq!(layout.check(), Err(LayoutError::Timescale { count: 5 }));
    }

    #[test]
    fn an_alias_of_an_alias_leads_to_the_variable() {
        let mut layout = with_var("a");
        let b = layout.alias(0, "b", 0);
        let c = layout.alias(0, "c", b);
        assert_eq!(layout.origin(c), 0);
    }
}
