//! Closed lists whose values have words in files and records.

/// An enum from one list of its values and their words: the enum itself, `ALL` in the same order, and the words.
#[macro_export]
macro_rules! listed {
    ($(#[$about:meta])* pub enum $name:ident: $word:ident {
        $($(#[$doc:meta])* $variant:ident = $text:literal),+ $(,)?
    }) => {
        $(#[$about])*
        pub enum $name { $($(#[$doc])* $variant),+ }

        impl $name {
            /// Every value, in the order of the lists.
            pub const ALL: [Self; [$($text),+].len()] = [$(Self::$variant),+];

            /// The variant's word in files and records.
            pub const fn $word(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }
        }
    };
}

pub(crate) use listed;
