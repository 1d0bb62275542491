//! Where the next page of a list begins, as text that means nothing to clients.

use base64::Engine;
use base64::prelude::BASE64_URL_SAFE_NO_PAD;

use crate::core::fleet_order::FleetOrder;
use crate::core::message::Message;
use crate::core::period::Period;
use crate::message;

/// A list in an order. A position means something in its own list only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum List {
    Records,
    Campaigns,
    Imus,
    Gyros(FleetOrder),
    Alerts,
    Audit,
    Deliveries,
    DiagnosisOrders,
    DiagnosisFailures,
    Trend(Option<Period>),
}

impl List {
    /// The first byte of its cursors. Cursors of other releases begin with 1, which is no list.
    const fn mark(self) -> u8 {
        match self {
            Self::Records => 2,
            Self::Campaigns => 3,
            Self::Imus => 4,
            Self::Gyros(FleetOrder::Serial) => 5,
            Self::Gyros(FleetOrder::Load) => 6,
            Self::Gyros(FleetOrder::Reach) => 7,
            Self::Gyros(FleetOrder::Age) => 8,
            Self::Alerts => 9,
            Self::Audit => 10,
            Self::Deliveries => 11,
            Self::DiagnosisOrders => 12,
            Self::DiagnosisFailures => 13,
            Self::Trend(None) => 14,
            Self::Trend(Some(Period::Day)) => 15,
            Self::Trend(Some(Period::Week)) => 16,
            Self::Trend(Some(Period::Month)) => LAST_MARK,
        }
    }
}

const LAST_MARK: u8 = 17;

pub fn encode(list: List, position: i64) -> String {
    let mut bytes = [0; 9];
    bytes[0] = list.mark();
    bytes[1..].copy_from_slice(&position.to_be_bytes());
    BASE64_URL_SAFE_NO_PAD.encode(bytes)
}

/// The position of a cursor in a list.
///
/// # Errors
/// What [`encode`] cannot have made, and what it made of another list or order.
pub fn decode(list: List, cursor: &str) -> Result<i64, Message> {
    let bytes = BASE64_URL_SAFE_NO_PAD.decode(cursor).unwrap_or_default();
    match bytes.split_first() {
        Some((mark, position)) if (2..=LAST_MARK).contains(mark) => {
            let position = position.try_into().map_err(|_| message!("invalid_cursor"))?;
            if *mark != list.mark() {
                return Err(message!("cursor_of_other_list"));
            }
            Ok(i64::from_be_bytes(position))
        }
        _ => Err(message!("invalid_cursor")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cursor_comes_back_to_its_own_list_and_order_only() {
        let gyros = FleetOrder::ALL.map(List::Gyros);
        let trends = [None, Some(Period::Day), Some(Period::Week), Some(Period::Month)].map(List::Trend);
        let lists = [
            List::Records,
            List::Campaigns,
            List::Imus,
            List::Alerts,
            List::Audit,
            List::Deliveries,
            List::DiagnosisOrders,
            List::DiagnosisFailures,
        ];
        let lists: Vec<List> = lists.into_iter().chain(gyros).chain(trends).collect();
        for list in &lists {
            for at in [0, -1, 1_772_352_000_000_000, i64::MAX, i64::MIN] {
                let cursor = encode(*list, at);
                assert_eq!(decode(*list, &cursor), Ok(at));
                for other in lists.iter().filter(|other| *other != list) {
                    assert_eq!(decode(*other, &cursor).unwrap_err().code, "cursor_of_other_list", "{list:?} {other:?}");
                }
            }
        }
    }

    #[test]
    fn a_made_up_cursor_is_refused() {
        for made_up in ["", "x", "AAAA", "AgAAAAAAAAA", "AQAAAAAAAAAA", "EgAAAAAAAAAA", "????"] {
            assert_eq!(decode(List::Records, made_up).unwrap_err().code, "invalid_cursor", "{made_up}");
        }
    }
}
