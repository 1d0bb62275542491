//! The columns of a table, each named once: by the type of its rows, which are written and read by that list.

use std::sync::Arc;

use super::error::Result;
use super::rows::{AnyRow, CellKind, Column, Found, Part, Row};
use crate::core::id::Id;
use crate::core::judge::Measured;
use crate::core::named::Named;
use crate::core::time::UtcMicros;

/// `part! { Of { id, place } }`: what a type's members hold, beside one another in this order.
macro_rules! part {
    ($of:ident { $($member:ident),+ $(,)? }) => { part! { $of { $($member),+ } |error| error } };
    ($of:ident { $($member:ident),+ } |$error:ident| $told:expr) => {
        impl $crate::store::rows::Part for $of {
            fn put(&self, row: &mut $crate::store::rows::Row<'_>) {
                $(row.put(&self.$member);)+
            }

            fn get(
                found: &mut $crate::store::rows::Found<'_, impl $crate::store::rows::AnyRow>,
            ) -> $crate::store::error::Result<Self> {
                let told = |$error: $crate::store::error::StoreError| $told;
                Ok(Self { $($member: found.part().map_err(told)?),+ })
            }
        }
    };
}

/// `columns! { Row in "table" { id, place: ["x", "y"] } }`: each member of a type with its columns, which is one of the
/// same name unless others are given.
macro_rules! columns {
    ($row:ident in $table:literal { $($member:ident $(: [$($column:literal),+])?),+ $(,)? }) => {
        impl $crate::store::rows::Columns for $row {
            const TABLE: &'static str = $table;
            const COLUMNS: &'static str =
                concat!($(", ", columns!(@listed $member $($($column)+)?)),+).split_at(", ".len()).1;
        }

        part! { $row { $($member),+ } |error| error.of($table) }
    };
    (@listed $member:ident) => { stringify!($member) };
    (@listed $member:ident $first:literal $($column:literal)*) => { concat!($first $(, ", ", $column)*) };
}

pub(super) use {columns, part};

impl<C: Column> Part for C {
    fn put(&self, row: &mut Row<'_>) {
        self.put_one(row);
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        Self::of(found.cell()?).ok_or_else(|| found.unknown())
    }
}

impl<C: Column> Part for Option<C> {
    fn put(&self, row: &mut Row<'_>) {
        match self {
            Some(value) => value.put_one(row),
            None => _ = row.null(C::KIND),
        }
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        let stored: Option<C::Stored> = found.cell()?;
        stored.map(|stored| C::of(stored).ok_or_else(|| found.unknown())).transpose()
    }
}

impl<P: Part, const N: usize> Part for [P; N] {
    fn put(&self, row: &mut Row<'_>) {
        self.iter().for_each(|part| part.put(row));
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        let parts: Vec<P> = (0..N).map(|_| found.part()).collect::<Result<_>>()?;
        Ok(parts.try_into().unwrap_or_else(|_| unreachable!("there are as many")))
    }
}

macro_rules! tuple {
    ($($part:ident $place:tt),+) => {
        impl<$($part: Part),+> Part for ($($part,)+) {
            fn put(&self, row: &mut Row<'_>) {
                $(self.$place.put(row);)+
            }

            fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
                Ok(($(found.part::<$part>()?,)+))
            }
        }
    };
}

tuple!(A 0, B 1);
tuple!(A 0, B 1, C 2);
tuple!(A 0, B 1, C 2, D 3);
tuple!(A 0, B 1, C 2, D 3, E 4);

macro_rules! column {
    ($of:ty as $stored:ty, $kind:ident: $put:expr, $get:expr) => {
        impl Column for $of {
            type Stored = $stored;
            const KIND: CellKind = CellKind::$kind;

            fn put_one(&self, row: &mut Row<'_>) {
                let put: fn(&Self, &mut Row<'_>) = $put;
                put(self, row);
            }

            fn of(stored: $stored) -> Option<Self> {
                let get: fn($stored) -> Option<Self> = $get;
                get(stored)
            }
        }
    };
}

column!(i64 as i64, Integer: |value, row| _ = row.integer(*value), Some);
column!(u32 as i64, Integer: |value, row| _ = row.integer(i64::from(*value)), |value| value.try_into().ok());
column!(u16 as i64, Integer: |value, row| _ = row.integer(i64::from(*value)), |value| value.try_into().ok());
column!(usize as i64, Integer: |value, row| _ = row.integer(*value as i64), |value| value.try_into().ok());
column!(bool as i64, Integer: |value, row| _ = row.integer(i64::from(*value)), |value| Some(value != 0));
column!(Id as i64, Integer: |value, row| _ = row.integer(value.0), |value| Some(Self(value)));
column!(UtcMicros as i64, Integer: |value, row| _ = row.integer(value.0), |value| Some(Self(value)));
column!(u64 as i64, Integer: |value, row| _ = row.integer(*value as i64), |value| value.try_into().ok());
column!(f64 as f64, Real: |value, row| _ = row.real(*value), Some);
column!(String as String, Text: |value, row| _ = row.text(value), Some);
column!(Arc<str> as String, Text: |value, row| _ = row.text(value), |value| Some(value.into()));
column!(Vec<u8> as Vec<u8>, Bytes: |value, row| _ = row.bytes(value), Some);

impl<N: Named> Column for N {
    type Stored = String;
    const KIND: CellKind = CellKind::Text;

    fn put_one(&self, row: &mut Row<'_>) {
        row.text(Named::name(*self));
    }

    fn of(stored: String) -> Option<Self> {
        Named::from_name(&stored)
    }
}

/// A checksum.
impl Part for [u8; 32] {
    fn put(&self, row: &mut Row<'_>) {
        row.bytes(self);
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        found.cell::<Vec<u8>>()?.try_into().map_err(|_| found.unknown())
    }
}

/// A figure and its standard deviation.
impl Part for Option<Measured> {
    fn put(&self, row: &mut Row<'_>) {
        row.put(&self.map(|measured| measured.value)).put(&self.and_then(|measured| measured.sd));
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        let [value, sd]: [Option<f64>; 2] = found.part()?;
        Ok(value.map(|value| Measured { value, sd }))
    }
}
