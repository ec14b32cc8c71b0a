//! Tables as columns: their way to Python, and on to readers of Arrow.

use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{
    Float32Type, Float64Type, Int32Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{
    ArrayRef, ArrowPrimitiveType, BooleanArray, PrimitiveArray, RecordBatch, RecordBatchIterator,
    StringArray,
};
use arrow_schema::{ArrowError, Field, Schema};
use bytemuck::{AnyBitPattern, NoUninit, cast_slice, pod_collect_to_vec};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyList};

/// The values of a column.
#[derive(Debug)]
pub enum Values {
    /// Numbers or truths, little-endian bytes of this type of numpy's.
    Raw(&'static str, Vec<u8>),
    /// Words.
    Words(Vec<String>),
}

macro_rules! raw {
    ($($kind:ty: $name:literal),*) => {$(
        impl From<Vec<$kind>> for Values {
            fn from(values: Vec<$kind>) -> Self {
                Self::Raw($name, cast_slice(&values).to_vec())
            }
        }
    )*};
}

raw!(u8: "|u1", u16: "<u2", u32: "<u4", u64: "<u8", i32: "<i4", f32: "<f4", f64: "<f8", bool: "|b1");

impl From<Vec<String>> for Values {
    fn from(words: Vec<String>) -> Self {
        Self::Words(words)
    }
}

/// Named columns of one length, in their order.
#[derive(Debug, Default)]
pub struct Table(Vec<(&'static str, Values)>);

impl Table {
    /// Adds a column of these rows.
    pub fn with<R, T>(mut self, name: &'static str, rows: &[R], value: impl Fn(&R) -> T) -> Self
    where
        Vec<T>: Into<Values>,
    {
        let values: Vec<T> = rows.iter().map(value).collect();
        self.0.push((name, values.into()));
        self
    }
}

impl<'py> IntoPyObject<'py> for Table {
    type Target = PyList;
    type Output = Bound<'py, PyList>;
    type Error = PyErr;

    /// A list of (name, type of numpy's or None, bytes or words).
    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        let all = PyList::empty(py);
        for (name, values) in self.0 {
            match values {
                Values::Raw(kind, bytes) => {
                    all.append((name, kind, PyBytes::new(py, &bytes)))?;
                }
                Values::Words(words) => all.append((name, py.None(), words))?,
            }
        }
        Ok(all)
    }
}

/// Numbers of bytes that may lie anywhere.
fn numbers<T: NoUninit + AnyBitPattern>(bytes: &[u8]) -> Vec<T> {
    pod_collect_to_vec(bytes)
}

/// A column for Arrow: of bytes by their type of numpy's, or of words.
fn column(kind: &str, data: &Bound<'_, PyAny>) -> PyResult<ArrayRef> {
    if kind == "words" {
        let words: Vec<String> = data.extract()?;
        return Ok(Arc::new(StringArray::from(words)));
    }
    let data: &[u8] = data.extract()?;
    macro_rules! of {
        ($kind:ty) => {
            Arc::new(PrimitiveArray::<$kind>::from(numbers::<
                <$kind as ArrowPrimitiveType>::Native,
            >(data)))
        };
    }
    Ok(match kind {
        "|b1" => {
            let truths: Vec<bool> = data.iter().map(|byte| *byte != 0).collect();
            Arc::new(BooleanArray::from(truths))
        }
        "|u1" => of!(UInt8Type),
        "<u2" => of!(UInt16Type),
        "<u4" => of!(UInt32Type),
        "<u8" => of!(UInt64Type),
        "<i4" => of!(Int32Type),
        "<i8" => of!(Int64Type),
        "<f4" => of!(Float32Type),
        "<f8" => of!(Float64Type),
        other => {
            let text = format!("expected a column of numbers, truths or words, found {other}");
            return Err(PyTypeError::new_err(text));
        }
    })
}

/// A table as a stream of Arrow's, by its C interface: what pandas, polars, pyarrow, DuckDB and others read.
#[pyfunction]
pub fn arrow_stream<'py>(
    py: Python<'py>,
    columns: Vec<(String, String, Bound<'py, PyAny>)>,
) -> PyResult<Bound<'py, PyCapsule>> {
    let wrong = |error: ArrowError| PyTypeError::new_err(error.to_string());
    let mut fields = Vec::new();
    let mut arrays = Vec::new();
    for (name, kind, data) in &columns {
        let array = column(kind, data)?;
        fields.push(Field::new(name, array.data_type().clone(), false));
        arrays.push(array);
    }
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(Arc::clone(&schema), arrays).map_err(wrong)?;
    let reader = RecordBatchIterator::new([Ok(batch)], schema);
    let stream = FFI_ArrowArrayStream::new(Box::new(reader));
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}
