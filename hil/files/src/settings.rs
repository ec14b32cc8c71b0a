//! Common parts of tables of settings: the ranges of their numbers, and defaults that stand beside their keys.

use std::ops::RangeInclusive;

/// Numbers that share a range: one, or those that a list or an option holds.
pub(super) trait Bounded {
    /// The type of a single number.
    type Number;

    /// The key of the first number outside a range, where all of them stand under `key`.
    fn outside(&self, key: &str, range: &RangeInclusive<Self::Number>) -> Option<String>;
}

macro_rules! numbers {
    ($($number:ty)+) => {$(
        impl Bounded for $number {
            type Number = Self;

            fn outside(&self, key: &str, range: &RangeInclusive<Self>) -> Option<String> {
                (!range.contains(self)).then(|| key.to_owned())
            }
        }
    )+};
}
numbers!(f64 i32 u8 u16 u32 usize);

impl<T: Bounded> Bounded for Option<T> {
    type Number = T::Number;

    fn outside(&self, key: &str, range: &RangeInclusive<T::Number>) -> Option<String> {
        self.as_ref()?.outside(key, range)
    }
}

impl<T: Bounded, const N: usize> Bounded for [T; N] {
    type Number = T::Number;

    fn outside(&self, key: &str, range: &RangeInclusive<T::Number>) -> Option<String> {
        first_outside(self, key, range)
    }
}

impl<T: Bounded> Bounded for Vec<T> {
    type Number = T::Number;

    fn outside(&self, key: &str, range: &RangeInclusive<T::Number>) -> Option<String> {
        first_outside(self, key, range)
    }
}

fn first_outside<T: Bounded>(
    items: &[T],
    key: &str,
    range: &RangeInclusive<T::Number>,
) -> Option<String> {
    let mut items = items.iter().enumerate();
    items.find_map(|(index, item)| item.outside(&format!("{key}[{index}]"), range))
}

/// Checks that the fields of a table lie in their ranges, one after the other. The key of a field is its path below
/// the key of the table; a field without a unit has none.
macro_rules! bounds {
    (
        $source:expr, $table:expr, $of:expr;
        $($($field:ident).+: $range:expr $(, $unit:literal)?);+ $(;)?
    ) => {
        Ok::<(), $crate::FileError>(())$(.and_then(|()| {
            let key = $crate::wording::inside($table, &[$(stringify!($field)),+].join("."));
            $source.range(&key, &$of.$($field).+, $range, concat!($($unit)?))
        }))+
    };
}

/// Table of settings of which a file states the differences from the defaults. A key without a value has the default
/// of its type.
macro_rules! settings {
    (@) => { Default::default() };
    (@ $value:expr) => { $value };
    (
        $(#[$of_table:meta])*
        $seen:vis struct $name:ident {
            $($(#[$of_key:meta])* $public:vis $key:ident: $kind:ty $(= $value:expr)?),+ $(,)?
        }
        $($(#[$of_default:meta])+ default)?
    ) => {
        #[derive(Debug, Clone, PartialEq, serde::Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        #[serde(default, deny_unknown_fields)]
        $(#[$of_table])*
        $seen struct $name { $($(#[$of_key])* $public $key: $kind),+ }

        impl Default for $name {
            $($(#[$of_default])+)?
            fn default() -> Self {
                Self { $($key: $crate::settings::settings!(@ $($value)?)),+ }
            }
        }
    };
}

pub(super) use {bounds, settings};
