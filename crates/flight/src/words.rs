//! Words of closed lists and figures with names, stable and fit for scripts: each list is written once, and here is
//! what all have.
//!
//! Front doors hand codes, words and figures on, so that the same can be said in other languages and units.

/// A figure of a finding or a remedy, for front doors that pass them on by name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Figure {
    /// Not known, unlimited, or not a number that could be said.
    Absent,
    /// Yes or no.
    Flag(bool),
    /// How many, or which one.
    Count(usize),
    /// A measure, in the unit of the figure's name.
    Number(f64),
    /// A word of a closed list, or the label of a parameter.
    Word(&'static str),
}

impl From<bool> for Figure {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<usize> for Figure {
    fn from(count: usize) -> Self {
        Self::Count(count)
    }
}

impl From<f64> for Figure {
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Number(number) } else { Self::Absent }
    }
}

impl From<&'static str> for Figure {
    fn from(word: &'static str) -> Self {
        Self::Word(word)
    }
}

impl<T: Into<Self>> From<Option<T>> for Figure {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Absent, Into::into)
    }
}

/// A closed list of words: the enum, and each as text. Described, the texts are the kebab-case names too.
macro_rules! words {
    ($(#[$meta:meta])* $list:ident { $($(#[$word_meta:meta])* $name:ident = $text:literal,)* }) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), serde(rename_all = "kebab-case"))]
        $(#[$meta])*
        pub enum $list { $($(#[$word_meta])* $name,)* }

        impl $list {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// The word, stable and fit for scripts.
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }
        }

        impl From<$list> for $crate::words::Figure {
            fn from(word: $list) -> Self {
                Self::Word(word.as_str())
            }
        }
    };
}

/// A closed list of kinds with their figures: the enum, the code of each as text, and its figures by name.
macro_rules! figured {
    ($(#[$meta:meta])* $list:ident { $($(#[doc = $doc:literal])* $name:ident = $code:literal {
        $($(#[$field_meta:meta])* $field:ident: $kind:ty,)*
    },)* }) => {
        #[derive(Debug, Clone, PartialEq)]
        #[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
        $(#[$meta])*
        pub enum $list {
            $($(#[doc = $doc])* $name {
                $($(#[$field_meta])* #[cfg_attr(feature = "describe", schema(required = true))] $field: $kind,)*
            },)*
        }

        impl $list {
            /// The code, stable and fit for scripts.
            pub const fn as_str(&self) -> &'static str {
                match self { $(Self::$name { .. } => $code,)* }
            }

            /// The figures by name, in the order in which they are declared.
            pub fn figures(&self) -> Vec<(&'static str, $crate::words::Figure)> {
                match self {
                    $(Self::$name { $($field,)* } => vec![$((stringify!($field), $crate::words::Figure::from(*$field)),)*],)*
                }
            }
        }
    };
}

pub(crate) use {figured, words};
