//! How a delivery to a hook stands.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeliveryState {
    /// An earlier one of the same hook and alert is not done.
    Behind,
    /// To be sent when it is due.
    Waiting,
    Delivered,
    /// Given up after the whole ladder, or because the target is gone.
    Dead,
    /// Its hook was deleted, or was told of everything that fires instead.
    Dropped,
}

impl DeliveryState {
    pub const ALL: [DeliveryState; 5] = [
        DeliveryState::Behind,
        DeliveryState::Waiting,
        DeliveryState::Delivered,
        DeliveryState::Dead,
        DeliveryState::Dropped,
    ];

    pub fn name(self) -> &'static str {
        match self {
            DeliveryState::Behind => "behind",
            DeliveryState::Waiting => "waiting",
            DeliveryState::Delivered => "delivered",
            DeliveryState::Dead => "dead",
            DeliveryState::Dropped => "dropped",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }
}
