//! What stands in a body under the same name as in the core.

use std::borrow::Cow;

use nalgebra::Vector3;

use super::geometry::GeometryBody;
use super::numbers::Numbers;
use crate::core::bench::BenchMethod;
use crate::core::effects::Effect;
use crate::core::id::Id;
use crate::core::mounting::Geometry;
use crate::core::name::Name;
use crate::core::named::Named;
use crate::wire::prelude::*;
use crate::wire::time;

/// A value of the core as a body has it.
pub(crate) trait ToBody<T> {
    fn to_body(&self) -> T;
}

/// `SpreadBody of Spread: sd, interval;` makes one of the other, member by member; `error_pulse_s = error` takes it from
/// a member of another name, of a member, or of a place (`share = 1`), and `shift: |moved| moved.now - moved.then`
/// computes it.
macro_rules! bodies {
    ($($body:ident of $core:ty: $($member:ident $(= $($of:tt).+)? $(: $make:expr)?),+;)+) => {$(
        impl From<&$core> for $body {
            fn from(core: &$core) -> Self {
                Self { $($member: $crate::wire::body::bodies!(@ core, $core, $member $(= $($of).+)? $(: $make)?)),+ }
            }
        }

        impl $crate::wire::body::ToBody<$body> for $core {
            fn to_body(&self) -> $body {
                self.into()
            }
        }
    )+};
    (@ $core:ident, $of:ty, $member:ident) => { $crate::wire::body::ToBody::to_body(&$core.$member) };
    (@ $core:ident, $of:ty, $member:ident = $($from:tt).+) => {
        $crate::wire::body::ToBody::to_body(&$core.$($from).+)
    };
    (@ $core:ident, $of:ty, $member:ident: $make:expr) => {{
        let make: fn(&$of) -> _ = $make;
        make($core)
    }};
}

pub(crate) use bodies;

macro_rules! as_it_is {
    ($($of:ty),*) => {$(
        impl ToBody<$of> for $of {
            fn to_body(&self) -> $of {
                self.clone()
            }
        }
    )*};
}

as_it_is!(f64, u64, usize, bool, String, BenchMethod, Slot);

impl ToBody<&'static str> for &'static str {
    fn to_body(&self) -> &'static str {
        self
    }
}

impl ToBody<String> for &'static str {
    fn to_body(&self) -> String {
        (*self).to_owned()
    }
}

impl ToBody<Cow<'static, str>> for &'static str {
    fn to_body(&self) -> Cow<'static, str> {
        (*self).into()
    }
}

impl<T: Named> ToBody<String> for T {
    fn to_body(&self) -> String {
        self.name().to_owned()
    }
}

impl<T: Named> ToBody<&'static str> for T {
    fn to_body(&self) -> &'static str {
        self.name()
    }
}

impl ToBody<String> for Effect {
    fn to_body(&self) -> String {
        self.id().to_owned()
    }
}

impl ToBody<String> for Name {
    fn to_body(&self) -> String {
        self.to_string()
    }
}

impl ToBody<String> for Id {
    fn to_body(&self) -> String {
        self.to_string()
    }
}

/// In the language that is asked for.
impl ToBody<String> for Message {
    fn to_body(&self) -> String {
        asked().words(self)
    }
}

impl ToBody<MessageBody> for Message {
    fn to_body(&self) -> MessageBody {
        MessageBody::of(self, asked())
    }
}

impl ToBody<String> for UtcMicros {
    fn to_body(&self) -> String {
        time::format(*self)
    }
}

/// A coefficient that the gyros share has no slot.
impl ToBody<String> for Option<Slot> {
    fn to_body(&self) -> String {
        self.map_or("all", Slot::name).to_owned()
    }
}

impl ToBody<Triple> for Vector3<f64> {
    fn to_body(&self) -> Triple {
        (*self).into()
    }
}

impl ToBody<[f64; 3]> for Vector3<f64> {
    fn to_body(&self) -> [f64; 3] {
        (*self).into()
    }
}

impl ToBody<Numbers> for Vector3<f64> {
    fn to_body(&self) -> Numbers {
        self.into()
    }
}

impl ToBody<Numbers> for Vec<f64> {
    fn to_body(&self) -> Numbers {
        self.as_slice().into()
    }
}

impl ToBody<GeometryBody> for Geometry {
    fn to_body(&self) -> GeometryBody {
        GeometryBody::of(self)
    }
}

impl<A: ToBody<B>, B> ToBody<Option<B>> for Option<A> {
    fn to_body(&self) -> Option<B> {
        self.as_ref().map(ToBody::to_body)
    }
}

impl<A: ToBody<B>, B> ToBody<Vec<B>> for Vec<A> {
    fn to_body(&self) -> Vec<B> {
        self.iter().map(ToBody::to_body).collect()
    }
}

impl<A: ToBody<B>, B, const N: usize> ToBody<[B; N]> for [A; N] {
    fn to_body(&self) -> [B; N] {
        std::array::from_fn(|i| self[i].to_body())
    }
}
