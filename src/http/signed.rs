//! Who does something, and why: the whole body of many requests.

use crate::http::prelude::*;

/// Who does it, and why.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Signed {
    #[schema(min_length = 1, max_length = 64)]
    pub by: String,
    #[schema(min_length = 1, max_length = 4096)]
    pub reason: String,
}

impl Signed {
    pub fn read(body: &Document) -> Answer<Self> {
        body.read(|bytes| {
            let Self { by, reason } = json::parse(bytes)?;
            let mut faults = Faults::default();
            let (by, reason) = text::signed("/by", by, reason, &mut faults);
            faults.or(Self { by, reason })
        })
    }
}
