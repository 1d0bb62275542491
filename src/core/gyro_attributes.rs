//! What a laboratory says of a gyro beside what is measured.

/// Words of the laboratory's own; none where nothing is said.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GyroAttributes {
    /// Of production.
    pub batch: Option<String>,
    /// Of gyro.
    pub r#type: Option<String>,
    /// The owner, or the vehicle that it flies in.
    pub unit: Option<String>,
}

/// What changes of them; none where it stays.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GyroAttributesPatch {
    pub batch: Option<Option<String>>,
    pub r#type: Option<Option<String>>,
    pub unit: Option<Option<String>>,
}

impl GyroAttributes {
    /// As they are after a change (RFC 7396).
    pub fn patched(&self, patch: &GyroAttributesPatch) -> Self {
        let of = |patch: &Option<Option<String>>, was: &Option<String>| patch.clone().unwrap_or_else(|| was.clone());
        Self {
            batch: of(&patch.batch, &self.batch),
            r#type: of(&patch.r#type, &self.r#type),
            unit: of(&patch.unit, &self.unit),
        }
    }
}
