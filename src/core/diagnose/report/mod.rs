//! Stages 3 and 4: how far the named effects close the gap, what remains, what it does to the coefficients and what
//! to measure next.

pub(super) mod against_reference;
pub(super) mod calibrated;
pub(super) mod closure;
pub(super) mod constancy;
pub(super) mod held_out;
pub(super) mod identifiability;
pub(super) mod impact;
pub(super) mod indistinguishable;
pub(super) mod named;
pub(super) mod next_dwells;
pub(super) mod quadratic_form;
pub(super) mod remaining;
pub(super) mod stated_errors;
pub(super) mod where_in_campaign;
pub(super) mod why_not_named;
