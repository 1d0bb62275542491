//! One file a table: its rows, what reads them and what writes them.

// What the tables' files are written with.
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use sqlx::AssertSqlSafe;

use crate::core::figures::Figures;
use crate::core::id::Id;
use crate::core::time::{Span, UtcMicros};
use crate::store::batch::{Batch, OnConflict};
use crate::store::columns::{columns, part};
use crate::store::db::{Bound, Readers, Sql, each, on, read, where_conditions};
use crate::store::rows::{AnyRow, CellKind, Column, Columns, Found, Part, Row, Rows};
use crate::store::{Result, Store, StoreError};

pub mod access;
pub mod alerts;
pub mod bench;
pub mod correction;
pub mod delivery;
pub mod diagnosis;
pub mod diagnosis_digest;
pub mod diagnosis_job;
pub mod event;
pub mod gyro_attribute;
pub mod head;
pub mod histories;
pub mod history;
pub mod hook;
pub mod hypothesis;
pub mod keys;
pub mod model;
pub mod names;
pub mod record;
pub mod set_aside;
pub mod silence;
pub mod suspect_window;

#[cfg(test)]
pub(super) mod delivery_tests;
