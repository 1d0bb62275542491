//! How a gyro stands, in one word: what the judging says, with the broken budget told from the mere warning.

use maud::{Markup, html};

use super::text::Text;
use crate::core::judge::{LimitKind, Rule, State};
use crate::pipeline::Standing;

/// Worst last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Grade {
    NotCalibrated,
    Within,
    Undecided,
    /// Only statistical limits are passed: it behaves otherwise than it used to.
    Warning,
    /// A budget or a requirement is broken.
    Exceeded,
}

impl Grade {
    pub fn of(standing: &Standing) -> Self {
        Self::judged(standing.state, standing.exceeded.iter().map(|(_, rule)| *rule))
    }

    /// From the worst state and the rules that are broken.
    pub fn judged(worst: Option<State>, mut broken: impl Iterator<Item = Rule>) -> Self {
        match worst {
            None => Self::NotCalibrated,
            Some(State::Within) => Self::Within,
            Some(State::Indeterminate) => Self::Undecided,
            Some(State::Exceeded) if broken.any(|rule| rule.limit_kind() == LimitKind::Specification) => Self::Exceeded,
            Some(State::Exceeded) => Self::Warning,
        }
    }

    /// As it stands in addresses and style sheets.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotCalibrated => "none",
            Self::Within => "within",
            Self::Undecided => "indeterminate",
            Self::Warning => "warning",
            Self::Exceeded => "exceeded",
        }
    }

    pub fn word(self, t: &Text) -> &'static str {
        match self {
            Self::NotCalibrated => t.no_record,
            Self::Within => t.within,
            Self::Undecided => t.indeterminate,
            Self::Warning => t.warning,
            Self::Exceeded => t.exceeded,
        }
    }

    /// By shape and word as well as by colour.
    pub fn badge(self, t: &Text) -> Markup {
        html! { span class={ "badge " (self.name()) } { (self.word(t)) } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_statistical_limit_alone_only_warns() {
        let exceeded = |rules: &[Rule]| Grade::judged(Some(State::Exceeded), rules.iter().copied());
        assert_eq!(exceeded(&[Rule::Cusum, Rule::Trend]), Grade::Warning);
        assert_eq!(exceeded(&[Rule::Cusum, Rule::Step]), Grade::Exceeded);
        assert_eq!(Grade::judged(None, std::iter::empty()), Grade::NotCalibrated);
        assert!(Grade::Exceeded > Grade::Warning && Grade::Warning > Grade::Undecided);
    }
}
