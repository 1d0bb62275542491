//! How the gyros are mounted, as documents say it: a name, or axes slot by slot.

use std::fmt;

use serde::Deserializer;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Unexpected, Visitor};

use crate::core::mounting::{Geometry, Triad};
use crate::wire::prelude::*;

/// `"skewed"` (the paper's Tables 1-2), `"orthogonal"`, or the nominal axes of each slot.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum GeometryBody {
    Named(NamedGeometry),
    Stated(Box<StatedAxes>),
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum NamedGeometry {
    Skewed,
    Orthogonal,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StatedAxes {
    #[serde(rename = "G1", default, skip_serializing_if = "Option::is_none")]
    pub g1: Option<AxesBody>,
    #[serde(rename = "G2", default, skip_serializing_if = "Option::is_none")]
    pub g2: Option<AxesBody>,
    #[serde(rename = "G3", default, skip_serializing_if = "Option::is_none")]
    pub g3: Option<AxesBody>,
    /// Of a fixture that carries one gyro: axes that need no slot, together with `spin`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<Triple>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<Triple>,
}

/// Nominal axes of one gyro: unit vectors in body axes, perpendicular to one another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AxesBody {
    pub input: Triple,
    pub spin: Triple,
}

impl GeometryBody {
    /// The core's geometry, or every fault of the stated axes with pointers below the geometry itself.
    pub fn to_core(&self) -> Result<Geometry, Faults> {
        match self {
            Self::Named(NamedGeometry::Skewed) => Ok(Geometry::Skewed),
            Self::Named(NamedGeometry::Orthogonal) => Ok(Geometry::Orthogonal),
            Self::Stated(axes) => axes.to_core(),
        }
    }

    /// Its name, or its axes slot by slot.
    pub fn of(geometry: &Geometry) -> Self {
        match geometry {
            Geometry::Skewed => Self::Named(NamedGeometry::Skewed),
            Geometry::Orthogonal => Self::Named(NamedGeometry::Orthogonal),
            Geometry::Custom(triads) => {
                let [g1, g2, g3] =
                    triads.map(|triad| triad.map(|t| AxesBody { input: t.input().into(), spin: t.spin().into() }));
                Self::Stated(Box::new(StatedAxes { g1, g2, g3, input: None, spin: None }))
            }
        }
    }
}

impl StatedAxes {
    fn to_core(&self) -> Result<Geometry, Faults> {
        let mut faults = Faults::default();
        let mut triads = [None; 3];
        for (slot, axes) in Slot::ALL.into_iter().zip([&self.g1, &self.g2, &self.g3]) {
            let Some(axes) = axes else { continue };
            match Triad::from_stated_axes(axes.input.vector(), axes.spin.vector()) {
                Ok(triad) => triads[slot.index()] = Some(triad),
                Err(part) => faults.absorb(&format!("/{}", slot.name()), part),
            }
        }
        if let Some(triad) = self.fixture(&mut faults) {
            triads = triads.map(|stated| stated.or(Some(triad)));
        }
        faults.or(Geometry::Custom(triads))
    }
}

impl StatedAxes {
    fn fixture(&self, faults: &mut Faults) -> Option<Triad> {
        match (self.input, self.spin) {
            (None, None) => None,
            (Some(input), Some(spin)) if self.g1.is_none() && self.g2.is_none() && self.g3.is_none() => {
                Triad::from_stated_axes(input.vector(), spin.vector()).map_err(|part| faults.absorb("", part)).ok()
            }
            (Some(_), Some(_)) => {
                faults.push("/input", message!("axes_stated_twice"));
                None
            }
            (Some(_), None) => {
                faults.push("/spin", message!("missing_beside", member = "input"));
                None
            }
            (None, Some(_)) => {
                faults.push("/input", message!("missing_beside", member = "spin"));
                None
            }
        }
    }
}

impl<'de> Deserialize<'de> for GeometryBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(GeometryVisitor)
    }
}

/// Reads either form directly, so that a fault inside the axes keeps its place (an untagged enum loses it).
struct GeometryVisitor;

impl<'de> Visitor<'de> for GeometryVisitor {
    type Value = GeometryBody;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"skewed\", \"orthogonal\" or an object with the axes of each slot")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<GeometryBody, E> {
        match name {
            "skewed" => Ok(GeometryBody::Named(NamedGeometry::Skewed)),
            "orthogonal" => Ok(GeometryBody::Named(NamedGeometry::Orthogonal)),
            _ => Err(E::invalid_value(Unexpected::Str(name), &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<GeometryBody, A::Error> {
        StatedAxes::deserialize(MapAccessDeserializer::new(map)).map(|axes| GeometryBody::Stated(Box::new(axes)))
    }
}
