//! Closed lists of words: an enum, the name of each of its variants and the way back, declared once by
//! [`crate::words!`].

/// An enum whose variants recipes and files call by a word each.
pub trait Words: Copy + PartialEq + 'static {
    /// Every variant, in the order of their declaration.
    const ALL: &'static [Self];
    /// Their names, in the same order.
    const NAMES: &'static [&'static str];

    /// Name in recipes and files.
    fn name(self) -> &'static str;

    /// The variant that is called `name`; `None` where none is.
    fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|known| known.name() == name)
    }
}

/// Declares an enum together with the word for each variant: `ALL`, `NAMES`, `name()` and [`Words`] follow.
///
/// ```
/// use base::Words;
///
/// base::words! {
///     /// Which way is up.
///     Up {
///         /// Along z.
///         Plus = "plus",
///         /// Against z.
///         Minus = "minus",
///     }
/// }
/// assert_eq!((Up::NAMES, Up::Minus.name()), (["plus", "minus"], "minus"));
/// assert_eq!((Up::named("plus"), Up::named("left")), (Some(Up::Plus), None));
/// ```
#[macro_export]
macro_rules! words {
    ($(#[$meta:meta])* $Name:ident { $($(#[$doc:meta])+ $Variant:ident = $word:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $Name {
            $($(#[$doc])+ $Variant,)+
        }

        impl $Name {
            /// Every variant, in the order of their declaration.
            pub const ALL: [$Name; [$($word),+].len()] = [$($Name::$Variant),+];
            /// Names in recipes and files, in the same order.
            pub const NAMES: [&'static str; [$($word),+].len()] = [$($word),+];

            /// Name in recipes and files.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$Variant => $word,)+
                }
            }
        }

        impl $crate::Words for $Name {
            const ALL: &'static [Self] = &$Name::ALL;
            const NAMES: &'static [&'static str] = &$Name::NAMES;

            fn name(self) -> &'static str {
                $Name::name(self)
            }
        }
    };
}
