//! One number, declared once: YAML key = stream name = Parquet column = struct field, with its unit and range.

/// The declaration of one drawable number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Group in the recipe, for instance `laser`.
    pub group: &'static str,
    /// Key inside the group; ends in its unit, for instance `wavelength_nm`.
    pub name: &'static str,
    /// Smallest value a draw may take.
    pub min: f64,
    /// Largest value a draw may take.
    pub max: f64,
    /// Value where the recipe says nothing.
    pub default: f64,
    /// A count: draws are rounded to the nearest whole number.
    pub integer: bool,
    /// What it means, one or two sentences.
    pub doc: &'static str,
    /// Where the default and the range come from.
    pub source: &'static str,
}

impl Parameter {
    /// `group.name`: the key path, the stream name and the Parquet column.
    pub fn path(&self) -> String {
        format!("{}.{}", self.group, self.name)
    }
}

/// Declares a group of parameters as a plain struct of `f64` fields plus its table.
///
/// ```
/// procedural::parameters! {
///     /// A lamp.
///     lamp: Lamp {
///         /// Optical power.
///         power_mw: 0.1, 500.0, 50.0, "class 3B at most";
///     }
/// }
/// let lamp = Lamp::from_values(&mut |p| p.default);
/// assert_eq!(lamp.power_mw, 50.0);
/// assert_eq!(Lamp::PARAMETERS[0].path(), "lamp.power_mw");
/// ```
///
/// The three numbers are the smallest, the largest and the default value; `count` after the source marks whole numbers.
#[macro_export]
macro_rules! parameters {
    ($(#[doc = $group_doc:literal])+ $group:ident : $Group:ident {
        $($(#[doc = $doc:literal])+ $name:ident : $min:expr, $max:expr, $default:expr, $source:literal $(, $count:ident)?;)+
    }) => {
        $(#[doc = $group_doc])+
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $Group {
            $($(#[doc = $doc])+ pub $name: f64,)+
        }

        impl $Group {
            /// Key of the group in the recipe.
            pub const GROUP: &'static str = stringify!($group);
            /// What the group is about.
            pub const DOC: &'static str = concat!($($group_doc,)+);
            /// The declarations, in the order of the fields.
            pub const PARAMETERS: &'static [$crate::Parameter] = &[$($crate::Parameter {
                group: stringify!($group),
                name: stringify!($name),
                min: $min,
                max: $max,
                default: $default,
                integer: $crate::parameters!(@count $($count)?),
                doc: concat!($($doc,)+),
                source: $source,
            },)+];

            /// Fills every field from `value`, asked once for each declaration in order.
            pub fn from_values(value: &mut dyn FnMut(&'static $crate::Parameter) -> f64) -> Self {
                let mut table = Self::PARAMETERS.iter();
                Self { $($name: value(table.next().expect(stringify!($name))),)+ }
            }

            /// Every declaration with its value here, in order.
            pub fn values(&self) -> Vec<(&'static $crate::Parameter, f64)> {
                Self::PARAMETERS.iter().zip([$(self.$name,)+]).collect()
            }
        }
    };
    (@count count) => { true };
    (@count) => { false };
}
