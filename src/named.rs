//! Words for the values of an enum.

/// Implements names for an enum: `NAMES`, `name`, `Display` and `FromStr`, whose error lists the known names.
macro_rules! named {
    ($type:ident, $what:literal, $first:ident = $first_name:literal $(, $variant:ident = $name:literal)*) => {
        impl $type {
            /// The known names, in the order in which they are listed to people.
            pub const NAMES: &'static [(&'static str, Self)] =
                &[($first_name, Self::$first) $(, ($name, Self::$variant))*];

            /// The name as people type it.
            pub const fn name(self) -> &'static str {
                match self {
                    Self::$first => $first_name,
                    $(Self::$variant => $name),*
                }
            }
        }

        impl core::fmt::Display for $type {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.pad(self.name())
            }
        }

        impl core::str::FromStr for $type {
            type Err = &'static str;

            fn from_str(word: &str) -> Result<Self, Self::Err> {
                let known = Self::NAMES.iter().find(|(name, _)| *name == word);
                known.map(|(_, value)| *value).ok_or(concat!(
                    "unknown ", $what, "; the known ones are ", $first_name $(, ", ", $name)*
                ))
            }
        }
    };
}
