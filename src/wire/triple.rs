//! Three numbers: a vector in body axes as it stands in a document.

use std::fmt;

use nalgebra::Vector3;
use serde::de::{Error, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// An array of exactly three finite numbers (JSON has no others). A wrong length is refused with the length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Triple(pub [f64; 3]);

impl Triple {
    /// As a vector, in the same order.
    pub fn vector(self) -> Vector3<f64> {
        Vector3::from(self.0)
    }
}

impl From<Vector3<f64>> for Triple {
    fn from(v: Vector3<f64>) -> Self {
        Self(v.into())
    }
}

impl<'de> Deserialize<'de> for Triple {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(TripleVisitor)
    }
}

struct TripleVisitor;

impl<'de> Visitor<'de> for TripleVisitor {
    type Value = Triple;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of 3 numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Triple, A::Error> {
        let mut values = [0.0; 3];
        let mut count = 0;
        while count < 3
            && let Some(value) = seq.next_element()?
        {
            values[count] = value;
            count += 1;
        }
        while seq.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        if count == 3 { Ok(Triple(values)) } else { Err(A::Error::invalid_length(count, &self)) }
    }
}

impl utoipa::PartialSchema for Triple {
    fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::schema::Schema> {
        utoipa::openapi::schema::ArrayBuilder::new()
            .items(<f64 as utoipa::PartialSchema>::schema())
            .min_items(Some(3))
            .max_items(Some(3))
            .into()
    }
}

impl utoipa::ToSchema for Triple {}
