//! How a gyro's history is looked at: by which method, on which axis, from when to when. All of it is in the address.

use super::prelude::*;
use crate::config::JudgedMethod;

/// Whose figures are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ShownMethod {
    Separation(JudgedMethod),
    /// The bench alone; separations beside it are by the rigid method.
    Bench,
}

impl ShownMethod {
    pub const ALL: [ShownMethod; 3] = [
        ShownMethod::Separation(JudgedMethod::Rigid),
        ShownMethod::Separation(JudgedMethod::Published),
        ShownMethod::Bench,
    ];

    pub fn asked(name: Option<&str>, judged: JudgedMethod) -> Self {
        Self::ALL.into_iter().find(|shown| Some(shown.name()) == name).unwrap_or(Self::Separation(judged))
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Separation(method) => method.name(),
            Self::Bench => "bench",
        }
    }

    pub fn title(self, t: &Text) -> &'static str {
        match self {
            Self::Separation(method) => t.method_of(method),
            Self::Bench => t.method_bench,
        }
    }

    pub fn separation(self) -> JudgedMethod {
        match self {
            Self::Separation(method) => method,
            Self::Bench => JudgedMethod::Rigid,
        }
    }

    /// Of the separation, as the API calls it.
    pub fn separation_name(self) -> &'static str {
        Self::Separation(self.separation()).name()
    }
}

impl Text {
    pub fn method_of(&self, method: JudgedMethod) -> &'static str {
        self.method(method.name())
    }
}

/// As it stands in an address; what cannot be read counts as left out.
#[derive(Debug, Default, Clone, Deserialize)]
#[serde(default)]
pub(super) struct ViewQuery {
    /// `rigid`, `published` or `bench`; the judged one where it is left out.
    method: Option<String>,
    /// `absolute`; deviations from the baseline where it is left out.
    axis: Option<String>,
    /// Days, or instants in RFC 3339.
    from: Option<String>,
    to: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    pub shown: ShownMethod,
    pub absolute: bool,
    pub from: Option<UtcMicros>,
    pub to: Option<UtcMicros>,
    pub judged: JudgedMethod,
}

impl View {
    /// The whole history by the judged method, as a report shows it.
    pub fn whole(judged: JudgedMethod) -> Self {
        Self { shown: ShownMethod::Separation(judged), absolute: false, from: None, to: None, judged }
    }

    pub fn asked(asked: &ViewQuery, judged: JudgedMethod) -> Self {
        let from = asked.from.as_deref().and_then(|from| time::parse_start(from).ok());
        let to = asked.to.as_deref().and_then(|to| time::parse_end(to).ok());
        let in_order = from.zip(to).is_none_or(|(from, to)| from < to);
        Self {
            shown: ShownMethod::asked(asked.method.as_deref(), judged),
            absolute: asked.axis.as_deref() == Some("absolute"),
            from: from.filter(|_| in_order),
            to: to.filter(|_| in_order),
            judged,
        }
    }

    /// Whether verdicts speak of the figures that are shown.
    pub fn is_judged(&self) -> bool {
        self.shown == ShownMethod::Separation(self.judged)
    }

    /// Whether an instant is in view.
    pub fn holds(&self, at: UtcMicros) -> bool {
        self.from.is_none_or(|from| from <= at) && self.to.is_none_or(|to| at <= to)
    }

    /// The query of its address: what differs from the plain page.
    pub fn address(&self) -> String {
        // Days where the ends are those of days.
        let day = |at: UtcMicros| {
            let text = time::format(at);
            let day =
                ["T00:00:00Z", "T23:59:59.999999Z"].iter().find_map(|end| text.strip_suffix(end).map(str::to_owned));
            day.unwrap_or(text)
        };
        let method = (!self.is_judged()).then(|| ("method", self.shown.name().to_owned()));
        let axis = self.absolute.then(|| ("axis", "absolute".to_owned()));
        let (from, to) = (self.from.map(|at| ("from", day(at))), self.to.map(|at| ("to", day(at))));
        let parts: Vec<String> =
            [method, axis, from, to].into_iter().flatten().map(|(key, value)| format!("{key}={value}")).collect();
        format!("?{}", parts.join("&"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(from: &str, to: &str) -> View {
        let asked = ViewQuery { from: Some(from.into()), to: Some(to.into()), ..ViewQuery::default() };
        View::asked(&asked, JudgedMethod::Rigid)
    }

    #[test]
    fn a_view_is_read_as_its_address_says() {
        let view = of("2025-03-01", "2025-06-30");
        assert!(view.holds(time::parse("2025-06-30T20:00:00Z").unwrap()), "the last day is in view");
        assert!(!view.holds(time::parse("2025-07-01T00:00:00Z").unwrap()));
        assert_eq!(view.address(), "?from=2025-03-01&to=2025-06-30");
        let hours = of("2025-03-01T08:00:00Z", "2025-03-01T20:00:00Z");
        assert_eq!(hours.address(), "?from=2025-03-01T08:00:00Z&to=2025-03-01T20:00:00Z");
        let bench = View { shown: ShownMethod::Bench, absolute: true, ..view };
        assert_eq!(bench.address(), "?method=bench&axis=absolute&from=2025-03-01&to=2025-06-30");
        assert_eq!(View::whole(JudgedMethod::Published).address(), "?");
    }

    #[test]
    fn what_cannot_be_read_or_ends_before_it_begins_is_the_whole() {
        for (from, to) in [("yesterday", ""), ("2025-06-30", "2025-03-01"), ("", "")] {
            let view = of(from, to);
            assert_eq!((view.from, view.to), (None, None), "{from} {to}");
        }
    }
}
