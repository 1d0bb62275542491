//! The names of what is stored, and whether an item counts.

use std::sync::RwLockReadGuard;

use crate::core::correction::CorrectionItem;
use crate::core::message::{Message, sent};
use crate::pipeline::prelude::*;
use crate::store::{ConfirmationRow, Tables};
use crate::wire::table::nearest;

/// The names of what is stored, while it is looked at.
#[derive(Debug)]
pub struct Names<'a>(pub(super) RwLockReadGuard<'a, Tables>);

impl Names<'_> {
    /// A number that was never given out has no name.
    pub fn imu(&self, number: u32) -> &str {
        self.0.imus.text(number)
    }

    pub fn station(&self, number: u32) -> &str {
        self.0.stations.text(number)
    }

    pub fn gyro(&self, number: u32) -> &str {
        self.0.gyros.text(number)
    }

    /// That no IMU has the name, with the one that it most resembles where one is near.
    pub fn unknown_imu(&self, imu: &str) -> Message {
        match nearest(imu, self.0.imus.all(), 8) {
            Some(known) => message!("unknown_imu_like", imu = sent(imu), known = sent(known)),
            None => message!("unknown_imu", imu = sent(imu)),
        }
    }

    pub fn imu_number(&self, imu: &str) -> Option<u32> {
        self.0.imus.number(imu)
    }

    pub fn station_number(&self, station: &str) -> Option<u32> {
        self.0.stations.number(station)
    }

    pub fn gyro_number(&self, serial: &str) -> Option<u32> {
        self.0.gyros.number(serial)
    }
}

/// Whether an item counts, and what was said of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ItemStatus {
    /// Of it, and of what it stands in the place of.
    pub corrections: Vec<CorrectionItem>,
    /// It does not count until somebody confirms its time.
    pub set_aside: bool,
    pub confirmation: Option<ConfirmationRow>,
    pub is_corrected: bool,
}

impl ItemStatus {
    /// It has neither been voided nor revised, and is not set aside.
    pub fn counts(&self) -> bool {
        !self.is_corrected && !self.set_aside
    }
}
