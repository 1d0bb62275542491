//! What is wrong with an input, and where. Validation collects every fault instead of stopping at the first.

use super::message::Message;

/// One fault: a JSON pointer (RFC 6901) into the document as the station wrote it, and what is wrong there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    pub pointer: String,
    pub message: Message,
}

/// Every fault that was found in one document, in no language where it is logged; never empty where it is returned as
/// an error.
#[derive(Debug, Clone, PartialEq, Eq, Default, thiserror::Error)]
#[error("{}", summary(.0))]
pub struct Faults(pub Vec<Fault>);

impl Faults {
    /// Adds a fault at a JSON pointer.
    pub fn push(&mut self, pointer: impl Into<String>, message: Message) {
        self.0.push(Fault { pointer: pointer.into(), message });
    }

    /// Whether there is no fault.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// `value` when nothing was found, the faults otherwise.
    pub fn or<T>(self, value: T) -> Result<T, Self> {
        if self.is_empty() { Ok(value) } else { Err(self) }
    }

    /// Adds the faults of a part of the document found below `prefix`.
    pub fn absorb(&mut self, prefix: &str, part: Faults) {
        for fault in part.0 {
            self.push(format!("{prefix}{}", fault.pointer), fault.message);
        }
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Self {
        Self(vec![fault])
    }
}

/// What is wrong with the document as a whole.
impl From<Message> for Faults {
    fn from(message: Message) -> Self {
        Fault { pointer: String::new(), message }.into()
    }
}

fn summary(faults: &[Fault]) -> String {
    let place = |f: &Fault| if f.pointer.is_empty() { "document".to_owned() } else { f.pointer.clone() };
    faults.iter().map(|f| format!("{}: {}", place(f), f.message)).collect::<Vec<_>>().join("; ")
}
