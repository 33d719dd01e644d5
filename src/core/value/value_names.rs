//! Names that people have for the values of a signal: states, quadrants, directions.

use crate::Value;

/// Values of one width and what they are called, in the order in which they were given.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ValueNames(Vec<(Value, String)>);

impl ValueNames {
    /// The longest name of a value, in characters: what is longer fits no waveform.
    pub const LONGEST: usize = 40;

    /// Why a text cannot be the name of a value, if it cannot.
    #[must_use]
    pub fn unfit(name: &str) -> Option<String> {
        if name.is_empty() {
            Some("is empty".to_owned())
        } else if name.chars().count() > ValueNames::LONGEST {
            Some(format!("has {} characters", name.chars().count()))
        } else if name.trim() != name {
            Some("begins or ends with a space".to_owned())
        } else {
            name.chars().find(|c| c.is_control() || *c == '#').map(|c| format!("holds {c:?}"))
        }
    }

    /// Of several names of one value the first counts.
    #[must_use]
    pub const fn new(names: Vec<(Value, String)>) -> ValueNames {
        ValueNames(names)
    }

    /// What a value is called.
    ///
    /// ```
    /// # use discreta_core as discreta;
    /// use discreta::{Value, netlist::ValueNames};
    /// let names = ValueNames::new(vec![(Value::from_u64(2, 2), "load".into())]);
    /// assert_eq!(names.of(&Value::from_u64(2, 2)), Some("load"));
    /// assert_eq!(names.of(&Value::from_u64(1, 2)), None);
    /// ```
    #[must_use]
    pub fn of(&self, value: &Value) -> Option<&str> {
        self.iter().find(|(named, _)| *named == value).map(|(_, name)| name)
    }

    /// What a value is called that is given bit by bit, the most significant first.
    #[must_use]
    pub fn of_bits(&self, bits: &str) -> Option<&str> {
        self.iter().find(|(named, _)| named.bit_string() == bits).map(|(_, name)| name)
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = (&Value, &str)> {
        self.0.iter().map(|(value, name)| (value, name.as_str()))
    }
}
