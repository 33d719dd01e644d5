//! What a waveform is about, said before it starts: timescale, scopes and variables.
//!
//! Plain data, checked once by [`Layout::check`]: a sink may then rely on every index and name.

use std::collections::HashSet;
use std::fmt;

use crate::Timescale;

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

/// A line of a file's header.
#[derive(Clone, Copy, Debug)]
pub(super) enum Declaration {
    /// What follows is in this scope.
    Open(usize),
    /// A variable.
    Var(usize),
    /// The scope ends.
    Close,
}

/// What a waveform is about.
///
/// ```
/// # mod discreta {
/// #     pub use discreta_core::*;
/// #     pub mod wave { pub use discreta_wave::*; }
/// # }
/// use discreta::wave::Layout;
/// let mut layout = Layout::default();
/// let top = layout.scope("line", None);
/// let adder = layout.scope("adder", Some(top));
/// let sum = layout.var(top, "sum", 8);
/// layout.alias(adder, "y", sum);
/// assert!(layout.check().is_ok());
/// ```
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Layout {
    /// How long one tick is.
    pub timescale: Timescale,
    /// The scopes, each after its parent; siblings in the order in which a viewer lists them.
    pub scopes: Vec<ScopeDecl>,
    /// The variables, in the order in which a viewer lists those of one scope.
    pub vars: Vec<VarDecl>,
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

    /// The declarations as a file has them: each scope with its variables and then the scopes in it.
    pub(super) fn outline(&self) -> Vec<Declaration> {
        // Children and variables of each scope, in order, without a list for each: indices sorted by scope.
        let mut scopes: Vec<usize> = (0..self.scopes.len()).collect();
        scopes.sort_by_key(|&i| self.scopes[i].parent);
        let mut vars: Vec<usize> = (0..self.vars.len()).collect();
        vars.sort_by_key(|&i| self.vars[i].scope);
        let children = |parent: Option<usize>| {
            let from = scopes.partition_point(|&i| self.scopes[i].parent < parent);
            let to = scopes.partition_point(|&i| self.scopes[i].parent <= parent);
            scopes[from..to].iter()
        };
        let mut outline = Vec::with_capacity(2 * scopes.len() + vars.len());
        let mut open = vec![children(None)];
        while let Some(siblings) = open.last_mut() {
            let Some(&scope) = siblings.next() else {
                open.pop();
                if !open.is_empty() {
                    outline.push(Declaration::Close);
                }
                continue;
            };
            outline.push(Declaration::Open(scope));
            let from = vars.partition_point(|&i| self.vars[i].scope < scope);
            let of_scope = vars[from..].iter().take_while(|&&i| self.vars[i].scope == scope);
            outline.extend(of_scope.map(|&i| Declaration::Var(i)));
            open.push(children(Some(scope)));
        }
        outline
    }

    /// Checks everything that a sink relies on.
    ///
    /// # Errors
    /// The first fault.
    pub fn check(&self) -> Result<(), LayoutError> {
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
        assert_eq!(layout.check(), Ok(()));
    }

    #[test]
    fn an_alias_of_an_alias_leads_to_the_variable() {
        let mut layout = with_var("a");
        let b = layout.alias(0, "b", 0);
        let c = layout.alias(0, "c", b);
        assert_eq!(layout.origin(c), 0);
    }
}
