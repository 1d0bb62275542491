//! Every word of the pages, in both languages side by side: what is missing in one does not compile.

mod effects;
mod sentences;
mod words;

pub(super) use words::Text;

use crate::core::access::Role;
use crate::core::bench::BenchMethod;
use crate::core::judge::{Coefficient, Event, Rule, Severity, Status};
use crate::core::message::Message;
use crate::message;

pub(super) use crate::words::Language;

impl Language {
    /// The words of the pages.
    pub(in crate::pages) fn text(self) -> &'static Text {
        match self {
            Self::English => &words::ENGLISH,
            Self::Chinese => &words::CHINESE,
        }
    }
}

impl Text {
    fn language(&self) -> Language {
        Language::from_tag(self.tag).unwrap_or_default()
    }

    pub fn words(&self, message: &Message) -> String {
        self.language().words(message)
    }

    /// A rule, an event, a status, a severity, a method: words without parameters.
    pub fn word(&self, message: &Message) -> &'static str {
        self.language().word(&message.code)
    }

    pub fn rule(&self, rule: Rule) -> &'static str {
        self.word(&rule.word())
    }

    pub fn event(&self, event: Event) -> &'static str {
        self.word(&event.word())
    }

    pub fn status(&self, status: Status) -> &'static str {
        self.word(&status.word())
    }

    pub fn severity(&self, severity: Severity) -> &'static str {
        self.word(&severity.word())
    }

    /// How an alert stands, by its name on the wire.
    pub fn standing(&self, name: &str) -> &'static str {
        match name {
            "acknowledged" => self.alert_acknowledged,
            "silenced" => self.alert_silenced,
            "resolved" => self.alert_resolved,
            _ => self.alert_firing,
        }
    }

    pub fn role(&self, role: Role) -> &'static str {
        match role {
            Role::Viewer => self.role_viewer,
            Role::Station => self.role_station,
            Role::Engineer => self.role_engineer,
            Role::Admin => self.role_admin,
        }
    }

    /// The state of a delivery by its name on the wire.
    pub fn delivery(&self, name: &str) -> &'static str {
        match name {
            "behind" => self.delivery_behind,
            "delivered" => self.delivery_delivered,
            "dead" => self.delivery_dead,
            "dropped" => self.delivery_dropped,
            _ => self.delivery_waiting,
        }
    }

    /// A method by its name on the wire.
    pub fn method(&self, name: &str) -> &'static str {
        match (name, BenchMethod::from_name(name)) {
            (_, Some(method)) => self.word(&method.word()),
            ("published", _) => self.word(&message!("method_published")),
            _ => self.word(&message!("method_rigid")),
        }
    }

    /// What shows that more remains, by its name on the wire.
    pub fn sign<'n>(&self, kind: &'n str) -> &'n str {
        match kind {
            "lack_of_fit" => self.sign_lack_of_fit,
            "spread" => self.sign_spread,
            "neighbours_in_time" => self.sign_neighbours_in_time,
            "runs_in_time" => self.sign_runs_in_time,
            "same_specific_force" => self.sign_same_force,
            "neighbouring_orientations" => self.sign_orientations,
            "similar_rates" => self.sign_similar_rates,
            "same_orientation_before" => self.sign_orientation_before,
            "similar_temperatures" => self.sign_temperatures,
            "harmonics" => self.sign_harmonics,
            "several_bad_dwells" => self.sign_bad_dwells,
            "one_shape_is_not_enough" => self.sign_one_shape,
            "wandering_in_time" => self.sign_wandering,
            "many_causes_at_once" => self.sign_many_causes,
            "tests_together" => self.sign_together,
            other => other,
        }
    }

    /// What noise is known from, by its name on the wire.
    pub fn noise_source(&self, name: &str) -> String {
        let spoken = self.spoken(name);
        if spoken != name {
            return spoken;
        }
        let words = name.split('+').map(|part| if part == "sem" { "standard errors" } else { part });
        words.collect::<Vec<_>>().join(" and ")
    }

    /// The phase of a dwell by its name on the wire.
    pub fn phase(&self, name: &str) -> &'static str {
        if name == "rate" { self.phase_rate } else { self.phase_static }
    }

    /// What a coefficient is, in a few words.
    pub fn meaning(&self, coefficient: Coefficient) -> &'static str {
        match coefficient {
            Coefficient::DI => self.meaning_d_i,
            Coefficient::DS => self.meaning_d_s,
            Coefficient::DO => self.meaning_d_o,
            Coefficient::E => self.meaning_e,
            Coefficient::G => self.meaning_g,
            Coefficient::All => self.meaning_all,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::effects::CATALOGUE;

    #[test]
    fn every_effect_has_a_name_in_both_languages() {
        for entry in CATALOGUE {
            let [english, chinese] = [Language::English, Language::Chinese].map(|l| l.text().effect(entry.effect));
            assert!(english.is_ascii() && english != entry.cause && !chinese.is_ascii(), "{}", entry.id);
        }
    }
}
