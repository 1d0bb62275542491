//! How two documents of the same kind differ, member by member.

use serde_json::Value;

use super::json::pointer_token;

/// So many members are named: of a campaign that was measured again, every output differs.
const MOST_NAMED: usize = 20;

/// Where a document that was sent differs from what is stored, by JSON pointers into the one that was sent.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Differences {
    /// A single empty one where the two have nothing in common.
    pub pointers: Vec<String>,
    /// How many there are beyond those that are named.
    pub further: usize,
}

impl Differences {
    /// Of two documents that are not of the same kind.
    pub fn in_everything() -> Self {
        Self { pointers: vec![String::new()], further: 0 }
    }

    /// None where both say the same. In which order the gyros stand says nothing: each is compared with the one in
    /// its slot.
    pub fn between(stored: Value, sent: &Value) -> Self {
        let mut found = Self::default();
        if stored != *sent {
            found.compare("", &in_order_of(stored, sent), sent);
        }
        found
    }

    /// Where they are, as people count.
    pub fn places(&self) -> impl Iterator<Item = String> {
        self.pointers.iter().map(|pointer| counted(pointer))
    }

    /// Whether both say the same.
    pub fn is_empty(&self) -> bool {
        self.pointers.is_empty()
    }

    fn compare(&mut self, pointer: &str, stored: &Value, sent: &Value) {
        match (stored, sent) {
            (Value::Object(x), Value::Object(y)) => {
                let mut keys: Vec<&String> = y.keys().chain(x.keys().filter(|key| !y.contains_key(*key))).collect();
                // The dwells come last: there are so many that nothing else might be named.
                keys.sort_by_key(|key| *key == "dwells");
                for key in keys {
                    let below = format!("{pointer}/{}", pointer_token(key));
                    match (x.get(key), y.get(key)) {
                        (Some(p), Some(q)) => self.compare(&below, p, q),
                        _ => self.push(below),
                    }
                }
            }
            (Value::Array(x), Value::Array(y)) if x.len() == y.len() => {
                for (i, (p, q)) in x.iter().zip(y).enumerate() {
                    self.compare(&format!("{pointer}/{i}"), p, q);
                }
            }
            _ if stored != sent => self.push(pointer.to_owned()),
            _ => {}
        }
    }

    fn push(&mut self, pointer: String) {
        if self.pointers.len() < MOST_NAMED {
            self.pointers.push(pointer);
        } else {
            self.further += 1;
        }
    }
}

/// `/dwells/8/output_pulse_s/2` as `dwells 9 output_pulse_s 3`.
pub fn counted(pointer: &str) -> String {
    let word = |token: &str| token.parse().map_or_else(|_| token.to_owned(), |place: usize| (place + 1).to_string());
    pointer.split('/').skip(1).map(word).collect::<Vec<_>>().join(" ")
}

/// `stored` with its gyros, and with them the outputs in its dwells, in the order of their slots in `sent`. Where a
/// slot is in `sent` alone there is nothing in its place; those that are stored alone come last.
fn in_order_of(mut stored: Value, sent: &Value) -> Value {
    let (Some(there), Some(wanted)) = (slots(&stored), slots(sent)) else { return stored };
    let found = wanted.iter().map(|slot| there.iter().position(|other| other == slot));
    let left_over = (0..there.len()).filter(|k| !wanted.contains(&there[*k]));
    let order: Vec<Option<usize>> = found.chain(left_over.map(Some)).collect();
    arrange(stored.get_mut("gyros"), &order);
    for dwell in stored.get_mut("dwells").and_then(Value::as_array_mut).into_iter().flatten() {
        for outputs in ["output_pulse_s", "output_sem_pulse_s"] {
            arrange(dwell.get_mut(outputs), &order);
        }
    }
    stored
}

fn slots(document: &Value) -> Option<Vec<&str>> {
    document.get("gyros")?.as_array()?.iter().map(|gyro| gyro.get("slot")?.as_str()).collect()
}

fn arrange(list: Option<&mut Value>, order: &[Option<usize>]) {
    if let Some(Value::Array(list)) = list {
        *list = order.iter().map(|place| place.and_then(|k| list.get(k).cloned()).unwrap_or_default()).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn between(stored: Value, sent: Value) -> Vec<String> {
        let found = Differences::between(stored, &sent);
        assert_eq!(found.further, 0);
        found.pointers
    }

    #[test]
    fn every_difference_is_found_at_any_depth_and_in_either_document() {
        let a = json!({"m": 1, "list": [{"x": 1}, {"x": 2}]});
        assert!(between(a.clone(), a.clone()).is_empty());
        assert_eq!(between(a.clone(), json!({"m": 2, "list": [{"x": 1}, {"x": 3}]})), ["/list/1/x", "/m"]);
        assert_eq!(between(a, json!({"m": 1, "list": [{"x": 1}]})), ["/list"]);
        assert_eq!(between(json!({}), json!({"n": null})), ["/n"]);
        assert_eq!(between(json!({"a/b": 1, "c": 2}), json!({"c": 2})), ["/a~1b"]);
    }

    #[test]
    fn places_are_named_as_people_count() {
        assert_eq!(counted("/dwells/8/output_pulse_s/2"), "dwells 9 output_pulse_s 3");
        assert_eq!(counted("/note"), "note");
    }

    #[test]
    fn gyros_are_compared_by_slot_and_outputs_go_with_them() {
        let gyro = |slot: &str, serial: &str| json!({"slot": slot, "serial": serial});
        let campaign = |gyros: Vec<Value>, outputs: Vec<f64>| json!({"gyros": gyros, "dwells": [{"output_pulse_s": outputs, "output_sem_pulse_s": outputs}]});
        let stored = || campaign(vec![gyro("G1", "A"), gyro("G2", "B")], vec![1.0, 2.0]);
        assert!(between(stored(), campaign(vec![gyro("G2", "B"), gyro("G1", "A")], vec![2.0, 1.0])).is_empty());
        let other = campaign(vec![gyro("G2", "B"), gyro("G1", "C")], vec![2.0, 1.5]);
        let dwell = ["/dwells/0/output_pulse_s/1", "/dwells/0/output_sem_pulse_s/1"];
        assert_eq!(between(stored(), other), ["/gyros/1/serial", dwell[0], dwell[1]]);
        let records = |gyros: Vec<Value>| json!({"gyros": gyros});
        let two = || records(vec![gyro("G1", "A"), gyro("G2", "B")]);
        assert_eq!(between(two(), records(vec![gyro("G2", "B")])), ["/gyros"], "one is missing");
        assert_eq!(between(two(), records(vec![gyro("G3", "C"), gyro("G1", "A")])), ["/gyros"], "another one");
        assert_eq!(
            between(two(), records(vec![gyro("G2", "B"), gyro("G3", "C"), gyro("G1", "A")])),
            ["/gyros/1"],
            "one more"
        );
    }

    #[test]
    fn so_many_are_named_and_the_dwells_last() {
        let campaign =
            |output: f64, note: &str| json!({"dwells": vec![json!({"output_pulse_s": [output]}); 30], "note": note});
        let found = Differences::between(campaign(1.0, "a"), &campaign(2.0, "b"));
        assert_eq!((found.pointers.len(), found.further), (MOST_NAMED, 11));
        assert_eq!(found.pointers[..2], ["/note", "/dwells/0/output_pulse_s/0"]);
    }
}
