//! Who hears of an alert.

use super::judge::{Rule, Severity};

/// Which alerts a hook is told of. The default lets everything pass.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Filter {
    /// Rules that pass; all of them where the list is empty.
    pub rules: Vec<Rule>,
    /// Serials that pass, a `*` standing for any run of characters; all of them where the list is empty.
    pub gyros: Vec<String>,
    /// The least severity that passes. A threshold and not a list, because the severity of an alert never falls while
    /// it fires: whoever was told that it fires is also told that it has resolved.
    pub severity: Option<Severity>,
}

impl Filter {
    pub fn passes(&self, rule: Rule, serial: &str, severity: Severity) -> bool {
        (self.rules.is_empty() || self.rules.contains(&rule))
            && (self.gyros.is_empty() || self.gyros.iter().any(|pattern| matches(pattern, serial)))
            && self.severity.is_none_or(|least| severity >= least)
    }
}

/// Whether `text` is `pattern`, in which each `*` stands for any run of characters, none included.
fn matches(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('*');
    let head = parts.next().unwrap_or_default();
    let Some(mut rest) = text.strip_prefix(head) else { return false };
    let Some(tail) = parts.next_back() else { return rest.is_empty() };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(tail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_any_run_of_characters() {
        for (pattern, text) in
            [("LFG-0101", "LFG-0101"), ("LFG-*", "LFG-0101"), ("*01", "LFG-0101"), ("L*-*1", "LFG-0101"), ("*", "x")]
        {
            assert!(matches(pattern, text), "{pattern} {text}");
        }
        for (pattern, text) in [
            ("LFG-0101", "LFG-01012"),
            ("LFG-0101", "lfg-0101"),
            ("LFG-*2", "LFG-0101"),
            ("*0101*0101", "LFG-0101"),
            ("ab*ba", "aba"),
            ("", "x"),
        ] {
            assert!(!matches(pattern, text), "{pattern} {text}");
        }
    }

    #[test]
    fn every_list_of_a_filter_has_to_let_the_alert_pass() {
        let filter = Filter {
            rules: vec![Rule::Step, Rule::Range],
            gyros: vec!["LFG-01*".into(), "LFG-0201".into()],
            severity: Some(Severity::Critical),
        };
        assert!(filter.passes(Rule::Range, "LFG-0101", Severity::Critical));
        assert!(!filter.passes(Rule::Trend, "LFG-0101", Severity::Critical));
        assert!(!filter.passes(Rule::Range, "LFG-0301", Severity::Critical));
        assert!(!filter.passes(Rule::Range, "LFG-0101", Severity::Warning));
        assert!(Filter::default().passes(Rule::Overdue, "", Severity::Warning));
    }
}
