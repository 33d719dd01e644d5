//! Four-valued values: equal to numbers and texts where they are known.

use discreta::value::Word;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyInt, PyString};

/// Bits that are 0, 1, x or z.
#[pyclass(frozen, module = "discreta")]
#[derive(Clone)]
pub struct Value {
    pub inner: discreta::Value,
}

/// A Python number as a value of so many bits.
fn of_int(number: &Bound<'_, PyAny>, width: u32) -> PyResult<discreta::Value> {
    let py = number.py();
    let too_wide = || PyValueError::new_err(format!("{number} needs more than {width} bits"));
    // two's complement of as many bits, and a sign that must be the same above
    let negative = number.lt(0)?;
    let above = number.call_method1("__rshift__", (width,))?;
    let fits = match negative {
        false => above.eq(0)?,
        true => width > 0 && number.call_method1("__rshift__", (width - 1,))?.eq(-1)?,
    };
    if !fits {
        return Err(too_wide());
    }
    let mask = PyInt::new(py, 1).call_method1("__lshift__", (width,))?.call_method1("__sub__", (1,))?;
    let bits = number.call_method1("__and__", (mask,))?;
    let bytes: Vec<u8> = bits.call_method1("to_bytes", (width.div_ceil(8).max(1), "little"))?.extract()?;
    let words: Vec<Word> = bytes
        .chunks(8)
        .map(|chunk| Word::known(chunk.iter().rev().fold(0, |all, &byte| all << 8 | u64::from(byte))))
        .collect();
    Ok(discreta::Value::from_words(&words, width))
}

/// What a signal of so many bits is given: a number, a text such as `"4'b10x1"`, or a value.
pub fn given(value: &Bound<'_, PyAny>, width: u32) -> PyResult<discreta::Value> {
    if let Ok(value) = value.cast::<Value>() {
        let inner = &value.get().inner;
        if inner.width() != width {
            return Err(PyValueError::new_err(format!("it has {width} bits, the value {}", inner.width())));
        }
        return Ok(inner.clone());
    }
    if let Ok(text) = value.cast::<PyString>() {
        let text = text.to_string();
        return discreta::Value::given(&text, width, false).map_err(|e| PyValueError::new_err(e.to_string()));
    }
    if value.is_instance_of::<PyInt>() || value.is_instance_of::<PyBool>() {
        return of_int(value, width);
    }
    // numbers of other kinds, as of numpy
    match value.call_method0("__index__") {
        Ok(number) => of_int(&number, width),
        Err(_) => {
            let kind = value.get_type().name()?;
            Err(PyTypeError::new_err(format!("a number, a text such as \"4'b10x1\" or a Value, not `{kind}`")))
        }
    }
}

#[pymethods]
impl Value {
    /// From a number, a text or another value.
    #[new]
    fn new(value: &Bound<'_, PyAny>, width: u32) -> PyResult<Value> {
        if !(1..=1 << 20).contains(&width) {
            return Err(PyValueError::new_err("a value has 1 to 1048576 bits"));
        }
        Ok(Value { inner: given(value, width)? })
    }

    /// How many bits.
    #[getter]
    fn width(&self) -> u32 {
        self.inner.width()
    }

    /// The bits as a text, the most significant first.
    #[getter]
    fn bits(&self) -> String {
        self.inner.bit_string()
    }

    /// Whether no bit is x or z.
    #[getter]
    fn is_known(&self) -> bool {
        self.inner.is_known()
    }

    /// The number in two's complement.
    #[getter]
    fn signed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let number = self.__int__(py)?;
        match self.inner.width().checked_sub(1).map(|top| self.inner.bit(top)) {
            Some(discreta::Logic::One) => {
                let all = PyInt::new(py, 1).call_method1("__lshift__", (self.inner.width(),))?;
                number.call_method1("__sub__", (all,))
            }
            _ => Ok(number),
        }
    }

    fn __int__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if !self.inner.is_known() {
            return Err(PyValueError::new_err(format!("{} is no number", self.inner)));
        }
        if let Some(number) = self.inner.to_u64() {
            return Ok(PyInt::new(py, number).into_any());
        }
        let bytes: Vec<u8> = self.inner.words().flat_map(|w| w.v.to_le_bytes()).collect();
        py.get_type::<PyInt>().call_method1("from_bytes", (bytes.as_slice(), "little"))
    }

    fn __index__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.__int__(py)
    }

    fn __bool__<'py>(&self, py: Python<'py>) -> PyResult<bool> {
        self.__int__(py)?.ne(0)
    }

    fn __len__(&self) -> usize {
        self.inner.width() as usize
    }

    /// The bit of an index, 0 the least significant: `"0"`, `"1"`, `"x"` or `"z"`.
    fn __getitem__(&self, index: i64) -> PyResult<String> {
        let width = i64::from(self.inner.width());
        let at = if index < 0 { index + width } else { index };
        if !(0..width).contains(&at) {
            return Err(pyo3::exceptions::PyIndexError::new_err(format!("bit {index} of a value of {width} bits")));
        }
        let bits = self.inner.bit_string();
        Ok(bits[(width - 1 - at) as usize..][..1].to_owned())
    }

    /// Bits are the same, x and z included; with a number, that it is known and that number; with a text, the bits.
    fn __eq__<'py>(&self, py: Python<'py>, other: &Bound<'py, PyAny>) -> PyResult<bool> {
        if let Ok(other) = other.cast::<Value>() {
            return Ok(self.inner == other.get().inner);
        }
        if let Ok(text) = other.cast::<PyString>() {
            let text = text.to_string();
            let same = discreta::Value::given(&text, self.inner.width(), false).is_ok_and(|v| v == self.inner);
            return Ok(same || text == self.inner.bit_string());
        }
        Ok(self.inner.is_known() && (self.__int__(py)?.eq(other)? || other.lt(0)? && self.signed(py)?.eq(other)?))
    }

    fn __hash__(&self) -> u64 {
        use std::hash::{DefaultHasher, Hash, Hasher};
        let mut hasher = DefaultHasher::new();
        self.inner.bit_string().hash(&mut hasher);
        hasher.finish()
    }

    fn __str__(&self) -> String {
        self.inner.to_string()
    }

    fn __repr__(&self) -> String {
        format!("Value(\"{}\", {})", self.inner, self.inner.width())
    }
}
