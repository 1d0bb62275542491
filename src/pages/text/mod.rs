//! Every word of the pages.

mod words;

pub(super) use words::Text;

use super::prelude::*;
use crate::core::bench::BenchMethod;
use crate::core::effects::Effect;
use crate::core::judge::{Coefficient, Event};
use crate::wire::diagnosis::sign_word;
use crate::wire::reason::Reason;
use crate::wire::unit;

pub(super) use crate::words::Language;

impl Text {
    pub fn words(&self, message: &Message) -> String {
        self.language().words(message).replace(" +- ", " ± ")
    }

    /// Why a verdict is what it is.
    pub fn reason(&self, reason: &Reason) -> String {
        reason.words(self.language()).replace(" +- ", " ± ")
    }

    /// A rule, an event, a status, a method: words without parameters.
    pub fn word(&self, message: &Message) -> &'static str {
        self.language().word(&message.code)
    }

    /// `1 gyro`, `3 gyros`.
    pub fn count_of_gyros(&self, count: usize) -> String {
        match (self.language(), count) {
            (Language::Chinese, _) => format!("{count} 个陀螺"),
            (_, 1) => format!("{count} {}", self.gyro_word),
            _ => format!("{count} {}", self.gyros),
        }
    }

    /// A unit of an answer as people write it: `deg/(h g0)`, `(°)/(h·g0)`.
    pub fn unit_of(&self, unit: &str) -> String {
        let of_people = unit::of_people(&match self.language() {
            Language::Chinese => unit::of_machines(unit).replace("deg", "(°)").replace('*', "·"),
            Language::English => unit.to_owned(),
        });
        of_people.replace("/year", self.a_year)
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

    /// How an alert stands, by its name on the wire.
    pub fn standing(&self, name: &str) -> &'static str {
        match name {
            "acknowledged" => self.alert_acknowledged,
            "silenced" => self.alert_silenced,
            "inhibited" => self.alert_inhibited,
            "resolved" => self.alert_resolved,
            _ => self.alert_firing,
        }
    }

    /// A step of an alert by its name on the wire.
    pub fn alert_step<'n>(&self, name: &'n str) -> &'n str {
        match name {
            "fire" => self.step_fires,
            "escalate" => self.step_escalates,
            "lower" => self.step_lowered,
            "repeat" => self.step_repeats,
            "resolve" => self.alert_resolved,
            "silent" => self.step_silent,
            "acknowledge" => self.alert_acknowledged,
            "unacknowledge" => self.unacknowledge,
            "silence" => self.alert_silenced,
            "unsilence" => self.unsilence,
            "comment" => self.comment,
            "inhibit" => self.alert_inhibited,
            other => other,
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

    pub fn method(&self, name: &str) -> &'static str {
        match (name, BenchMethod::from_name(name)) {
            (_, Some(method)) => self.word(&method.word()),
            ("published", _) => self.word(&message!("method_published")),
            _ => self.word(&message!("method_rigid")),
        }
    }

    /// A short name of an effect.
    pub fn effect(&self, effect: Effect) -> &'static str {
        effect.hypothesis().map_or_else(|| self.word(&effect.word()), |own| &own.written.words)
    }

    /// What shows that more remains, by its name on the wire: of a test, or of a competing hypothesis.
    pub fn sign<'n>(&self, kind: &'n str) -> &'n str {
        sign_word(kind, self.language())
    }

    /// What noise is known from, by its name on the wire.
    pub fn noise_source(&self, name: &str) -> &'static str {
        self.language().word(&format!("noise_{}", name.replace('+', "_")))
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
    fn units_are_spelled_one_way_in_a_language() {
        let of_both = |unit: &str| [Language::English, Language::Chinese].map(|one| one.text().unit_of(unit));
        for (unit, english, chinese) in [
            ("deg/(h*g0)", "deg/(h g0)", "(°)/(h·g0)"),
            ("deg/(h*g0)/year", "deg/(h g0) a year", "(°)/(h·g0)/年"),
            ("deg/h/K", "deg/h/K", "(°)/h/K"),
            ("deg/(h g0^2)", "deg/(h g0²)", "(°)/(h·g0²)"),
            ("pulse/(s*g0)", "pulse/(s g0)", "pulse/(s·g0)"),
            ("ppm", "ppm", "ppm"),
        ] {
            assert_eq!(of_both(unit), [english, chinese], "{unit}");
        }
        for language in [Language::English, Language::Chinese] {
            assert_eq!(language.text().unit_of("deg/(h*g0)"), language.text().unit);
        }
    }

    #[test]
    fn every_effect_has_a_name_in_both_languages() {
        for entry in CATALOGUE {
            let [english, chinese] = [Language::English, Language::Chinese].map(|l| l.text().effect(entry.effect));
            assert!(english.is_ascii() && english != entry.cause && !chinese.is_ascii(), "{}", entry.id);
        }
    }
}
