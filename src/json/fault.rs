//! Errors inside of the deserializer, and how a type's own reading hands a whole diagnostic through serde.

use std::fmt;

use serde::de::{self, Expected, Unexpected};

use crate::diag::{Code, Diagnostic};

/// An error made of a diagnostic with its own place. Serde lets only text through, so the diagnostic travels behind
/// its message; [`parse`](super::parse) unpacks it, other deserializers show it after the message.
pub fn fault<E: de::Error>(diagnostic: Diagnostic) -> E {
    E::custom(Carried(&[diagnostic]))
}

/// As [`fault`], when all there is to say has been told already.
pub(super) fn told<E: de::Error>() -> E {
    E::custom(Carried(&[]))
}

const MARK: &str = "\0discreta\0";

struct Carried<'a>(&'a [Diagnostic]);

impl fmt::Display for Carried<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let message = self.0.first().map_or("a part of it is faulty", |d| &d.message);
        write!(f, "{message}{MARK}{}", serde_json::to_string(self.0).map_err(|_| fmt::Error)?)
    }
}

/// Why a part could not be read.
#[derive(Debug)]
pub(super) enum Error {
    /// With their places; none if everything has been told.
    Faults(Vec<Diagnostic>),
    /// Without a place: the part that was being read.
    Here(Code, String),
    /// A struct's field.
    Missing(&'static str),
}

impl Error {
    pub(super) const TOLD: Error = Error::Faults(Vec::new());
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Faults(list) => f.write_str(list.first().map_or("a part of it is faulty", |d| &d.message)),
            Error::Here(_, message) => f.write_str(message),
            Error::Missing(field) => write!(f, "the field `{field}` is missing"),
        }
    }
}

impl std::error::Error for Error {}

impl de::Error for Error {
    fn custom<T: fmt::Display>(message: T) -> Error {
        let text = message.to_string();
        if let Some((_, carried)) = text.rsplit_once(MARK)
            && let Ok(list) = serde_json::from_str(carried)
        {
            return Error::Faults(list);
        }
        Error::Here(Code::BadValue, text)
    }

    fn invalid_type(unexpected: Unexpected<'_>, expected: &dyn Expected) -> Error {
        Error::Here(Code::WrongType, format!("expected {expected}, found {unexpected}"))
    }

    fn missing_field(field: &'static str) -> Error {
        Error::Missing(field)
    }
}
