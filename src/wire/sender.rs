//! Who sent a record, as clients read it.

use serde::Serialize;
use utoipa::ToSchema;

/// Who sent something.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct SenderBody {
    /// Name of the token; `local` before there was one, `setup` with the setup secret.
    pub name: String,
    /// Identifier of the token.
    #[schema(required)]
    pub token: Option<String>,
    /// The address that it came from.
    pub address: String,
    /// The program that sent it, by its own word (`User-Agent`).
    #[schema(required)]
    pub agent: Option<String>,
}
