//! What is wrong with a configuration.

#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    #[error("configuration cannot be read: {0}")]
    Unreadable(#[from] config::ConfigError),
    #[error("configuration key {key}: {detail}")]
    Key { key: String, detail: String },
}
