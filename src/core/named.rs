//! Enums whose values have a name on the wire, and some of them words: [`Rule::Step`](crate::core::judge::Rule) is
//! `step`, its words are those of `rule_step`.

/// `named! { pub enum Rule("rule_") { Step = "step", ... } }`: the enum with `ALL`, `name`, `from_name` and `word`;
/// without the prefix of its words, all but `word`. With `("rule_", letter) { Step = "step" 'S', ... }` also `letter`.
macro_rules! named {
    ($(#[$on_all:meta])* pub enum $of:ident($prefix:literal, letter) {
        $($(#[$on_one:meta])* $one:ident = $name:literal $letter:literal,)*
    }) => {
        $crate::core::named::named! { $(#[$on_all])* pub enum $of($prefix) { $($(#[$on_one])* $one = $name,)* } }

        impl $of {
            /// Its letter in a picture, as control charts have them.
            pub fn letter(self) -> char {
                match self { $($of::$one => $letter),* }
            }
        }
    };
    ($(#[$on_all:meta])* pub enum $of:ident($prefix:literal) { $($(#[$on_one:meta])* $one:ident = $name:literal,)* }) => {
        $crate::core::named::named! { $(#[$on_all])* pub enum $of { $($(#[$on_one])* $one = $name,)* } }

        impl $of {
            /// What people read.
            pub fn word(self) -> $crate::core::message::Message {
                let code = match self { $($of::$one => concat!($prefix, $name)),* };
                $crate::core::message::Message::new(code, Vec::new())
            }
        }
    };
    ($(#[$on_all:meta])* pub enum $of:ident { $($(#[$on_one:meta])* $one:ident = $name:literal,)* }) => {
        $(#[$on_all])*
        pub enum $of { $($(#[$on_one])* $one),* }

        impl $crate::core::named::Named for $of {
            const NAMES: &'static [&'static str] = &[$($name),*];

            fn name(self) -> &'static str {
                self.name()
            }

            fn from_name(name: &str) -> Option<Self> {
                Self::from_name(name)
            }
        }

        impl $of {
            pub const ALL: [$of; [$($name),*].len()] = [$($of::$one),*];

            /// Its name in answers and in the database; never changes once it has been given out.
            pub fn name(self) -> &'static str {
                match self { $($of::$one => $name),* }
            }

            /// The one of that name; none where no one has it.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|one| one.name() == name)
            }
        }
    };
}

pub(crate) use named;

/// An enum made by [`named`].
pub trait Named: Copy {
    /// In the order of its values.
    const NAMES: &'static [&'static str];

    fn name(self) -> &'static str;

    fn from_name(name: &str) -> Option<Self>;
}
