//! Plain values of a file as its types read them, and the key at which reading stopped.
//!
//! A reader of serde's is compiled once for every type, so the code that does not depend on the type stands here in
//! functions that are not generic. A list is no table, and a table no word, whatever else serde could make of them.

use std::cell::RefCell;
use std::fmt::Write;

use serde::Deserializer;
use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Error, Expected, MapAccess, SeqAccess, Visitor,
};
use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

use super::wording::Misfit;

/// Reads a type from a value; else returns the key of a misfit, and the expectation there.
pub(super) fn read<T: DeserializeOwned>(value: &Value) -> Result<T, (String, Misfit)> {
    let key = RefCell::new(String::new());
    let read = T::deserialize(At { value, key: &key });
    read.map_err(|misfit| (key.into_inner(), misfit))
}

/// Plain values of a text; else the key of a number that no machine holds, and the expectation there.
pub(super) fn table(parsed: &DeTable<'_>) -> Result<Table, (String, &'static str)> {
    let mut key = String::new();
    entries(&mut key, parsed).map_err(|expected| (key, expected))
}

// The key stays as it is at a misfit, because it is the key of the error.

fn entries(key: &mut String, parsed: &DeTable<'_>) -> Result<Table, &'static str> {
    let mut table = Table::new();
    for (name, item) in parsed {
        let outer = enter(key, name.get_ref());
        table.insert(name.get_ref().to_string(), plain(key, item.get_ref())?);
        key.truncate(outer);
    }
    Ok(table)
}

fn plain(key: &mut String, parsed: &DeValue<'_>) -> Result<Value, &'static str> {
    Ok(match parsed {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Boolean(truth) => Value::Boolean(*truth),
        DeValue::Datetime(time) => Value::Datetime(*time),
        DeValue::Integer(number) => {
            let read = i64::from_str_radix(number.as_str(), number.radix());
            Value::Integer(read.map_err(|_| "a whole number of at most 64 bits")?)
        }
        DeValue::Float(number) => {
            let read = number.as_str().parse::<f64>().ok();
            Value::Float(read.filter(|n| n.is_finite()).ok_or("a finite number")?)
        }
        DeValue::Array(items) => {
            let mut values = Vec::with_capacity(items.len());
            for (index, item) in items.iter().enumerate() {
                let outer = enter_item(key, index);
                values.push(plain(key, item.get_ref())?);
                key.truncate(outer);
            }
            Value::Array(values)
        }
        DeValue::Table(inner) => Value::Table(entries(key, inner)?),
    })
}

/// Goes to a key of a table; returns what [`String::truncate`] takes to go back.
fn enter(key: &mut String, name: &str) -> usize {
    let outer = key.len();
    if outer > 0 {
        key.push('.');
    }
    key.push_str(name);
    outer
}

fn enter_item(key: &mut String, index: usize) -> usize {
    let outer = key.len();
    // A string takes any key.
    let _ = write!(key, "[{index}]");
    outer
}

/// A value, and the key under way.
#[derive(Clone, Copy)]
struct At<'v> {
    value: &'v Value,
    key: &'v RefCell<String>,
}

impl<'v> At<'v> {
    fn text(self, expected: &dyn Expected) -> Result<&'v str, Misfit> {
        let text = self.value.as_str();
        text.ok_or_else(|| Misfit::of_value(expected))
    }

    fn items(self, expected: &dyn Expected) -> Result<Items<'v>, Misfit> {
        let items = self.value.as_array();
        let items = items.ok_or_else(|| Misfit::of_value(expected))?;
        Ok(Items {
            all: items,
            taken: 0,
            key: self.key,
        })
    }

    fn entries(self, expected: &dyn Expected) -> Result<Entries<'v>, Misfit> {
        let table = self.value.as_table();
        let table = table.ok_or_else(|| Misfit::of_value(expected))?;
        Ok(Entries {
            left: table.iter(),
            here: None,
            key: self.key,
        })
    }
}

/// Items of a list, one after the other.
struct Items<'v> {
    all: &'v [Value],
    taken: usize,
    key: &'v RefCell<String>,
}

impl<'v> Items<'v> {
    /// The next item, and the length that leads back from it.
    fn next(&mut self) -> Option<(At<'v>, usize)> {
        let value = self.all.get(self.taken)?;
        let outer = enter_item(&mut self.key.borrow_mut(), self.taken);
        self.taken += 1;
        let key = self.key;
        Some((At { value, key }, outer))
    }

    fn end(&self) -> Result<(), Misfit> {
        match self.taken == self.all.len() {
            true => Ok(()),
            false => Err(Misfit::of_value(&"fewer elements in array")),
        }
    }
}

impl<'de> SeqAccess<'de> for &mut Items<'_> {
    type Error = Misfit;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Misfit> {
        let Some((at, outer)) = self.next() else {
            return Ok(None);
        };
        let item = seed.deserialize(at)?;
        self.key.borrow_mut().truncate(outer);
        Ok(Some(item))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.all.len() - self.taken)
    }
}

/// Keys of a table and their values, one after the other.
struct Entries<'v> {
    left: toml::map::Iter<'v, String, Value>,
    here: Option<(&'v str, &'v Value)>,
    key: &'v RefCell<String>,
}

impl<'v> Entries<'v> {
    fn name(&mut self) -> Option<StrDeserializer<'v, Misfit>> {
        let (name, value) = self.left.next()?;
        self.here = Some((name, value));
        Some(StrDeserializer::new(name))
    }

    /// The value of the key that was taken last, and the length that leads back from it.
    fn value(&mut self) -> Result<(At<'v>, usize), Misfit> {
        let here = self.here.take();
        let (name, value) = here.ok_or_else(|| Error::custom("a value before its key"))?;
        let outer = enter(&mut self.key.borrow_mut(), name);
        let key = self.key;
        Ok((At { value, key }, outer))
    }
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Misfit;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Misfit> {
        self.name().map(|name| seed.deserialize(name)).transpose()
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Misfit> {
        let (at, outer) = self.value()?;
        let value = seed.deserialize(at)?;
        self.key.borrow_mut().truncate(outer);
        Ok(value)
    }
}

/// Reads numbers of every width alike: the type knows its own range.
macro_rules! numbers {
    ($($method:ident)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
            match self.value {
                Value::Integer(number) => visitor.visit_i64(*number),
                Value::Float(number) => visitor.visit_f64(*number),
                _ => Err(Misfit::of_value(&visitor)),
            }
        }
    )*};
}

impl<'de> Deserializer<'de> for At<'_> {
    type Error = Misfit;

    numbers! {
        deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64
        deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64
        deserialize_f32 deserialize_f64
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match self.value {
            Value::Boolean(truth) => visitor.visit_bool(*truth),
            _ => Err(Misfit::of_value(&visitor)),
        }
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        let text = self.text(&visitor)?;
        visitor.visit_str(text)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        self.deserialize_str(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        let mut items = self.items(&visitor)?;
        let read = visitor.visit_seq(&mut items)?;
        items.end()?;
        Ok(read)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Misfit> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        let entries = self.entries(&visitor)?;
        visitor.visit_map(entries)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        self.deserialize_map(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        let word = self.text(&visitor)?;
        visitor.visit_enum(StrDeserializer::new(word))
    }

    /// Serves types that take whatever there is, such as a choice that a tag among other keys makes.
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match self.value {
            Value::Boolean(_) => self.deserialize_bool(visitor),
            Value::Integer(_) | Value::Float(_) => self.deserialize_f64(visitor),
            Value::String(_) => self.deserialize_str(visitor),
            Value::Array(_) => self.deserialize_seq(visitor),
            Value::Table(_) => self.deserialize_map(visitor),
            Value::Datetime(_) => Err(Misfit::of_value(&visitor)),
        }
    }

    serde::forward_to_deserialize_any! {
        i128 u128 char bytes byte_buf unit unit_struct tuple_struct identifier ignored_any
    }
}
