//! Values of the core that stand in documents by their names.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, Visitor};
use serde::{Deserializer, Serializer};
use utoipa::PartialSchema;
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

use crate::core::bench::BenchMethod;
use crate::core::history_note::{NameKind, Quantity};
use crate::core::named::Named;
use crate::core::separate::JudgedMethod;
use crate::wire::prelude::*;

struct ByName<T>(PhantomData<T>);

impl<T: Named> Visitor<'_> for ByName<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a string")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
        T::from_name(name).ok_or_else(|| E::unknown_variant(name, T::NAMES))
    }
}

/// `Slot as "SlotBody"`: the type, and its name in the description of the API.
macro_rules! by_name {
    ($($of:ty as $name:literal,)*) => { $(
        impl Serialize for $of {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> Deserialize<'de> for $of {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_str(ByName(PhantomData))
            }
        }

        impl PartialSchema for $of {
            fn schema() -> RefOr<Schema> {
                ObjectBuilder::new().schema_type(Type::String).enum_values(Some(<$of>::NAMES.iter().copied())).into()
            }
        }

        impl ToSchema for $of {
            fn name() -> std::borrow::Cow<'static, str> {
                $name.into()
            }
        }
    )* };
}

by_name! {
    Slot as "SlotBody",
    BenchMethod as "BenchMethodBody",
    JudgedMethod as "MethodBody",
    NameKind as "NameKind",
    Quantity as "Quantity",
}
