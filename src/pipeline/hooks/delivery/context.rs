//! What all delivery queues share.

use std::time::Duration;

use crate::alert::deliver::Courier;
use crate::alert::ladder::Ladder;
use crate::pipeline::hooks::Hooks;

/// How often while another server delivers, or the lease is only late in being renewed.
pub(super) const OFF_DUTY: Duration = Duration::from_secs(1);

pub(super) struct DeliveryContext {
    pub hooks: Hooks,
    pub courier: Courier,
    pub ladder: Ladder,
}
