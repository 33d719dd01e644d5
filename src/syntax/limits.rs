//! How large a circuit may be.

macro_rules! limits {
    ($($field:ident $name:literal $default:expr, $doc:literal;)*) => {
        /// Bounds that are checked before memory is taken. `docs/format.md` lists them.
        #[derive(Debug, Clone, PartialEq, Eq)]
        pub struct Limits {
            $(#[doc = $doc] pub $field: u64,)*
        }

        impl Default for Limits {
            fn default() -> Limits {
                Limits { $($field: $default,)* }
            }
        }

        impl Limits {
            /// The names of all limits and what they bound.
            pub const ALL: &'static [(&'static str, &'static str)] = &[$(($name, $doc),)*];

            /// The limit called `name`.
            #[must_use]
            pub fn get(&self, name: &str) -> Option<u64> {
                match name {
                    $($name => Some(self.$field),)*
                    _ => None,
                }
            }

            fn get_mut(&mut self, name: &str) -> Option<&mut u64> {
                match name {
                    $($name => Some(&mut self.$field),)*
                    _ => None,
                }
            }
        }
    };
}

limits! {
    file_size "file-size" 256 << 20, "Bytes of one file.";
    width "width" 65_536, "Bits of one net.";
    repeat "repeat" 1 << 20, "Copies made by one `repeat`.";
    depth "depth" 256, "Modules and blocks inside one another.";
    cells "cells" 1 << 22, "Cells, nets and copies of the whole circuit.";
    bits "bits" 1 << 26, "Bits of all nets and connections together.";
}

impl Limits {
    /// Sets one limit, as written on the command line: `NAME=VALUE`.
    ///
    /// ```
    /// let mut limits = discreta::circuit::Limits::default();
    /// limits.set("width=1000000").unwrap();
    /// assert_eq!(limits.width, 1_000_000);
    /// assert_eq!(limits.set("wdith=1").unwrap_err(), "there is no limit `wdith`; did you mean `width`?");
    /// ```
    ///
    /// # Errors
    /// If the text is not of that form, or there is no such limit.
    pub fn set(&mut self, text: &str) -> Result<(), String> {
        let Some((name, value)) = text.split_once('=') else {
            return Err(format!("`{text}` is not of the form NAME=VALUE"));
        };
        let (name, value) = (name.trim(), value.trim());
        let names = || Limits::ALL.iter().map(|&(name, _)| name);
        let Some(limit) = self.get_mut(name) else {
            let hint = match crate::diag::nearest(name, names()) {
                Some(nearest) => format!("did you mean `{nearest}`?"),
                None => format!("the limits are {}", names().collect::<Vec<_>>().join(", ")),
            };
            return Err(format!("there is no limit `{name}`; {hint}"));
        };
        let value: u64 =
            value.replace('_', "").parse().map_err(|_| format!("`{value}` is not a whole number (of 64 bits)"))?;
        *limit = value;
        let most = self.clone().possible().get(name).unwrap_or(value);
        if value > most {
            return Err(format!("the limit `{name}` cannot be more than {most}"));
        }
        Ok(())
    }

    /// These limits, but not beyond what can be counted.
    #[must_use]
    pub(crate) fn possible(self) -> Limits {
        const MOST: u64 = u32::MAX as u64 - 1;
        Limits { bits: self.bits.min(MOST), width: self.width.min(MOST / 2), cells: self.cells.min(MOST / 2), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_those_of_the_documentation() {
        let doc = include_str!("../../docs/format.md").split_once("## Limits").unwrap().1;
        let limits = Limits::default();
        for &(name, _) in Limits::ALL {
            let row = doc.lines().find(|l| l.starts_with(&format!("| `{name}` |"))).unwrap();
            let value = row.split('|').nth(2).unwrap().trim();
            let value = match value.strip_suffix(" MiB") {
                Some(mega) => mega.parse::<u64>().unwrap() << 20,
                None => value.parse().unwrap(),
            };
            assert_eq!(limits.get(name), Some(value), "{name}");
        }
    }

    #[test]
    fn setting() {
        let mut limits = Limits::default();
        assert_eq!(limits.set("cells = 1_000"), Ok(()));
        assert_eq!(limits.cells, 1000);
        assert!(limits.set("cells").is_err());
        assert!(limits.set("cells=-1").is_err());
        assert!(limits.set("cells=99999999999999999999").is_err());
        assert_eq!(limits.set("bits=5000000000").unwrap_err(), "the limit `bits` cannot be more than 4294967294");
        assert_eq!(limits.set("depth=5000000000"), Ok(()));
        assert!(limits.set("zzzzz=1").unwrap_err().contains("file-size, width"));
    }
}
