//! How a delivery to a hook stands.

use crate::core::named::named;
use crate::core::time::UtcMicros;

named! {
/// How far a message to a hook has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeliveryState {
    /// An earlier one of the same hook and alert is not done.
    Behind = "behind",
    /// To be sent when it is due.
    Waiting = "waiting",
    Delivered = "delivered",
    /// Given up after the whole ladder, or because the target is gone.
    Dead = "dead",
    /// Its hook was deleted, or was told of everything that fires instead.
    Dropped = "dropped",
}
}

/// How the queue of a hook stands, or the queues of all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QueueState {
    pub open: i64,
    pub dead: i64,
    pub oldest_open: Option<UtcMicros>,
}
