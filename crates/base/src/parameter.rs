//! One number, declared once: YAML key = stream name = Parquet column = struct field, with its unit and range.

use crate::Natural;

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
    /// How it varies where a recipe says nothing and does not hold it at the default.
    pub natural: Natural,
    /// What it needs to mean something; of several the first that is not met is told.
    pub conditions: &'static [Condition],
}

/// Numbers that are declared together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterGroup {
    /// Its key in the recipe.
    pub path: &'static str,
    /// What it is about.
    pub doc: &'static str,
    /// The declarations, in order.
    pub parameters: &'static [Parameter],
}

/// What a number needs to mean something, and what becomes of a recipe that gives the number without it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// What the number needs.
    pub need: Need,
    /// What becomes of it otherwise.
    pub unmet: Unmet,
}

/// What becomes of a number whose need no sample meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unmet {
    /// Any other value than its default is a fault (`needs`).
    Refused,
    /// Any other value than its default is noted: a class to come may have the thing that it is of (`of`).
    Noted,
    /// Any other value than 0 is a fault, its default too (`zero_without`).
    Zero,
}

/// What a number needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Need {
    /// One of some words of a setting of its section, by the setting's path.
    On(&'static str, &'static [&'static str]),
    /// One of some words of any setting, by the setting's path.
    While(&'static str, &'static [&'static str]),
    /// Another number that can be other than 0, by its path.
    Amount(&'static str),
    /// A factor that can be other than 1, by its path.
    Factor(&'static str),
    /// One of several such amounts.
    Any(&'static [&'static str]),
    /// One of several such amounts, or boards of some sources, which have the thing whatever is counted.
    AnyOrLog(&'static [&'static str], &'static [&'static str]),
    /// Facets of metal.
    Facets,
    /// Fibres.
    Fibres,
    /// Room for a tablet that stands on its edge.
    RoomToStand,
    /// A tablet that is no ellipse or stadium as long as wide: of these both are a circle.
    Outline,
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
/// base::parameters! {
///     /// A lamp.
///     lamp: Lamp {
///         /// Optical power.
///         power_mw: 0.1, 500.0, 50.0, "class 3B at most", uniform(45.0, 55.0);
///         /// How many of them.
///         count: 1.0, 4.0, 1.0, "free", fixed, count;
///     }
/// }
/// let lamp = Lamp::from_values(&mut |p| p.default);
/// assert_eq!(lamp.power_mw, 50.0);
/// assert_eq!(Lamp::PARAMETERS[0].path(), "lamp.power_mw");
/// assert_eq!(Lamp::PARAMETERS[0].natural.ends(), Some([45.0, 55.0]));
/// assert_eq!(Lamp::PARAMETERS[1].natural, base::Natural::Fixed);
/// ```
///
/// The three numbers are the smallest, the largest and the default value. Source and [`Natural`] variation follow:
/// `fixed`, `uniform(min, max)`, `log_uniform(min, max)`, `normal(mean, sd)` or `one_of(value, ...)`. Marks come last:
/// first `count`, of whole numbers; then what the number needs to mean something, `needs [...]`, `of [...]` and
/// `zero_without [...]`, of which [`Unmet`] says the difference.
#[macro_export]
macro_rules! parameters {
    ($(#[doc = $group_doc:literal])+ $group:ident : $Group:ident {
        $($(#[doc = $doc:literal])+ $name:ident : $min:expr, $max:expr, $default:expr, $source:literal,
            $natural:ident $(($($argument:expr),+))? $(, $mark:ident $([$($need:expr),+])?)*;)+
    }) => {
        $(#[doc = $group_doc])+
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $Group {
            $($(#[doc = $doc])+ pub $name: f64,)+
        }

        impl $Group {
            /// Key of the group in the recipe.
            pub const GROUP: &'static str = stringify!($group);
            /// The paths of the declarations, in the order of the fields.
            pub const PATHS: &'static [&'static str] = &[$(concat!(stringify!($group), ".", stringify!($name)),)+];
            /// What the group is about.
            pub const DOC: &'static str = concat!($($group_doc,)+);
            /// The declarations, in the order of the fields.
            pub const PARAMETERS: &'static [$crate::Parameter] = &[$($crate::Parameter {
                group: stringify!($group),
                name: stringify!($name),
                min: $min,
                max: $max,
                default: $default,
                integer: $crate::parameters!(@integer $($mark)*),
                doc: concat!($($doc,)+),
                source: $source,
                natural: $crate::parameters!(@natural $natural $($($argument),+)?),
                conditions: &[$($($($crate::Condition { need: $need, unmet: $crate::parameters!(@$mark) },)+)?)*],
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
    (@natural fixed) => { $crate::Natural::Fixed };
    (@natural uniform $min:expr, $max:expr) => { $crate::Natural::Uniform { min: $min, max: $max } };
    (@natural log_uniform $min:expr, $max:expr) => { $crate::Natural::LogUniform { min: $min, max: $max } };
    (@natural normal $mean:expr, $sd:expr) => { $crate::Natural::Normal { mean: $mean, sd: $sd } };
    (@natural one_of $($value:expr),+) => { $crate::Natural::OneOf(&[$($value),+]) };
    (@integer count $($mark:ident)*) => { true };
    (@integer $($mark:ident)*) => { false };
    (@needs) => { $crate::Unmet::Refused };
    (@of) => { $crate::Unmet::Noted };
    (@zero_without) => { $crate::Unmet::Zero };
}

/// Declares everything that makes a thing: a plain struct whose fields are groups of
/// [`parameters!`](crate::parameters).
#[macro_export]
macro_rules! parameter_groups {
    ($(#[doc = $doc:literal])+ $Name:ident { $($(#[doc = $field_doc:literal])+ $field:ident: $Group:ty;)+ }) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $Name {
            $($(#[doc = $field_doc])+ pub $field: $Group,)+
        }

        impl $Name {
            /// The groups, in the order of the fields.
            pub const GROUPS: &'static [$crate::ParameterGroup] = &[$($crate::ParameterGroup {
                path: <$Group>::GROUP,
                doc: <$Group>::DOC,
                parameters: <$Group>::PARAMETERS,
            },)+];

            /// Fills every group from `value`, asked once for each declaration in order.
            pub fn from_values(value: &mut dyn FnMut(&'static $crate::Parameter) -> f64) -> Self {
                Self { $($field: <$Group>::from_values(value),)+ }
            }

            /// Every declaration with its value here, in order.
            pub fn values(&self) -> Vec<(&'static $crate::Parameter, f64)> {
                [$(self.$field.values(),)+].concat()
            }
        }
    };
}
