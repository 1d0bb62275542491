//! One coefficient of an effect as a campaign says it.

use crate::core::mounting::Slot;

/// A coefficient of an effect. `slot` is none for coefficients that all gyros share.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    pub slot: Option<Slot>,
    pub name: &'static str,
    pub value: f64,
    pub sd: f64,
    pub unit: &'static str,
}
