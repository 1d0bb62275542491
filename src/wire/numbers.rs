//! Short lists of numbers, read without allocating and without losing their length.

use std::fmt::{self, Display};

use nalgebra::Vector3;
use serde::de::{SeqAccess, Visitor};
use serde::{Deserializer, Serializer};

use crate::core::message::text;
use crate::wire::prelude::*;

const KEPT: usize = 4;

/// Largest magnitude that any number of a document may have. Nothing on a test table comes near it, and the
/// squares and sums of what passes cannot overflow.
pub const LARGEST: f64 = 1e12;

/// Takes off the last bits that an angle, in degrees or arcsec, to radians and back leaves.
pub fn tidy(angle: f64) -> f64 {
    (angle * 1e12).round() / 1e12
}

/// A list of numbers as the document has it. Only the first four are kept: no legal list is longer, and of an
/// illegal one the length is all that is reported.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numbers {
    values: [f64; KEPT],
    length: usize,
}

impl Numbers {
    /// The numbers, where there are exactly `N` and all are finite and of sane size; otherwise every fault.
    /// `pointer` is written out only for a fault: pass `format_args!` where many lists are read.
    pub fn exactly<const N: usize>(&self, pointer: impl Display, faults: &mut Faults) -> Option<[f64; N]> {
        let values = self.slice(N, pointer, faults)?;
        Some(std::array::from_fn(|i| values[i]))
    }

    /// The numbers that are kept: all of a legal list.
    pub fn values(&self) -> &[f64] {
        &self.values[..self.length.min(KEPT)]
    }

    /// Each number as `of` makes it.
    pub fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self { values: self.values.map(of), ..self }
    }

    /// Three numbers; a fault where there are more or fewer.
    pub fn vector(&self, pointer: impl Display, faults: &mut Faults) -> Option<Vector3<f64>> {
        self.exactly::<3>(pointer, faults).map(Vector3::from)
    }

    /// As [`Numbers::exactly`], for a length known only at run time.
    pub fn slice(&self, length: usize, pointer: impl Display, faults: &mut Faults) -> Option<&[f64]> {
        if self.length != length || length > KEPT {
            faults.push(pointer.to_string(), message!("wrong_length", need = length, have = self.length));
            return None;
        }
        let mut sound = true;
        for (i, &value) in self.values[..length].iter().enumerate() {
            sound &= in_range(value, format_args!("{pointer}/{i}"), faults);
        }
        sound.then(|| &self.values[..length])
    }
}

/// Whether `value` is finite and at most [`LARGEST`] in magnitude; a fault at `pointer` where it is not.
pub fn in_range(value: f64, pointer: impl Display, faults: &mut Faults) -> bool {
    let sound = value.abs() <= LARGEST;
    if !sound {
        faults.push(
            pointer.to_string(),
            message!("magnitude_at_most", most = format_args!("{LARGEST:e}"), value = text(value)),
        );
    }
    sound
}

impl From<&[f64]> for Numbers {
    fn from(list: &[f64]) -> Self {
        Self { values: std::array::from_fn(|i| list.get(i).copied().unwrap_or(0.0)), length: list.len() }
    }
}

impl From<&Vector3<f64>> for Numbers {
    fn from(v: &Vector3<f64>) -> Self {
        v.as_slice().into()
    }
}

impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.values().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberList;
        impl<'de> Visitor<'de> for NumberList {
            type Value = Numbers;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list of numbers")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Numbers, A::Error> {
                let mut list = Numbers { values: [0.0; KEPT], length: 0 };
                while let Some(value) = seq.next_element::<f64>()? {
                    if let Some(slot) = list.values.get_mut(list.length) {
                        *slot = value;
                    }
                    list.length += 1;
                }
                Ok(list)
            }
        }
        deserializer.deserialize_seq(NumberList)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Option<[f64; 3]>, Vec<String>) {
        let mut faults = Faults::default();
        let numbers: Numbers = serde_json::from_str(text).expect("a list");
        let found = numbers.exactly::<3>("/v", &mut faults);
        (found, faults.0.into_iter().map(|f| format!("{} {}", f.pointer, f.message)).collect())
    }

    #[test]
    fn wrong_lengths_and_sizes_are_named() {
        assert_eq!(read("[1, 2, 3]"), (Some([1.0, 2.0, 3.0]), vec![]));
        assert_eq!(read("[1, 2]").1, ["/v wrong_length (need: 3, have: 2)"]);
        assert_eq!(read("[1, 2, 3, 4, 5, 6]").1, ["/v wrong_length (need: 3, have: 6)"]);
        assert_eq!(read("[1, 1e13, -1e308]").1.len(), 2);
    }
}
