//! Pictures drawn by the service, for pages, for paper and for reports that stand alone: points with their bars
//! against levels and limits, over time or over any other figure.
//!
//! Whatever stands along the x axis is placed in per cent of the width and whatever stands along the y axis in pixels,
//! so that a picture fills its place on a telephone, a desk and a sheet of paper while its words keep their size.
//! Colours are those of the style sheet.

mod ticks;

use std::fmt::Write;

use super::prelude::*;
use super::status::sign;
use ticks::{dates, figures_apart, round_steps};

/// How wide the figures of the left axis are, and room above the points, pixels. The style sheet's `.picture` and
/// `.area` leave as much.
const LEFT: f64 = 66.0;
const TOP: f64 = 14.0;
/// Below the points: figures of the x axis, and one lane.
const BOTTOM: f64 = 20.0;
const LANE: f64 = 15.0;
/// What keeps two words apart that stand one above the other.
const LINE: f64 = 12.0;
/// A picture shows the budget and a little more, whatever was measured.
const LEAST_RANGE: f64 = 1.15;
/// Of how few points (one in so many, and at least so many) is what lies so many times as far off as all others, or as
/// the budget, drawn at the edge: a few that are far off, and a few more that would leave nothing to be seen of the rest.
const EDGES: [(usize, usize, f64); 2] = [(20, 1, 2.5), (8, 2, 10.0)];
/// Places across a picture that a pointer tells apart; each leads to one point.
const COLUMNS: f64 = 320.0;
/// More points than this have no bars: they would cover one another.
const MOST_BARS: usize = 400;

/// What stands along the x axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) enum XAxis {
    /// Milliseconds since 1970.
    #[default]
    Time,
    /// A figure, with its unit or name.
    Figure(String),
}

/// One measured point.
#[derive(Debug, Clone, Default)]
pub(super) struct DataPoint {
    pub x: f64,
    pub y: f64,
    pub sd: Option<f64>,
    /// None for what is not judged.
    pub status: Option<Status>,
    /// Letters of the rules that speak.
    pub letters: String,
    /// Where it leads.
    pub href: Option<String>,
    /// All that is known of it, in words.
    pub said: String,
}

/// Points that belong together, in the order of x.
#[derive(Debug, Clone, Default)]
pub(super) struct Track {
    /// `record`, `bench0`, `k0` …: of the style sheet.
    pub class: String,
    pub dots: Vec<DataPoint>,
    /// Where a line through the points is interrupted: a new level begins at these x.
    pub breaks: Vec<f64>,
    /// Whether a line leads from point to point.
    pub joined: bool,
    /// In place of points that are too many: of stretches the x, the lowest, the median, the highest.
    pub envelope: Vec<[f64; 4]>,
}

/// What the points from one x to another are held against.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
    pub from: f64,
    pub until: f64,
    pub at: f64,
    /// Either side of it.
    pub budget: Option<f64>,
    pub control: Option<f64>,
    /// Either side of it, without lines.
    pub shade: Option<f64>,
    /// From and until of the points that made it.
    pub made: Option<(f64, f64)>,
    /// What it is.
    pub label: String,
}

/// A stretch of a lane under the x axis.
#[derive(Debug, Clone)]
pub(super) struct Segment {
    pub from: f64,
    pub until: f64,
    pub label: String,
    /// Stretches with the same number have the same colour.
    pub kind: usize,
}

/// Something that happened, with its number in the list under the pictures.
#[derive(Debug, Clone)]
pub(super) struct Flag {
    pub x: f64,
    /// When it was over, of what took time.
    pub until: Option<f64>,
    pub number: usize,
    /// Of its line in that list.
    pub anchor: String,
    pub label: String,
}

/// A straight course carried on, and between which instants it meets the budget.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extrapolation {
    pub line: [(f64, f64); 3],
    /// Early and late; the points are where the edges of the band end.
    pub cone: Option<[(f64, f64); 2]>,
}

/// One picture.
#[derive(Debug, Clone, Default)]
pub(super) struct Chart {
    /// For those who do not see it, and above it.
    pub label: String,
    pub caption: Markup,
    pub across: XAxis,
    pub x: (f64, f64),
    /// How far the y axis reaches at least, on either side of zero or of the levels.
    pub around: f64,
    /// Both ends of the y axis, where several pictures share them.
    pub range: Option<(f64, f64)>,
    /// What 100 % is, for the right axis.
    pub whole: Option<f64>,
    pub signed: bool,
    pub levels: Vec<Level>,
    pub tracks: Vec<Track>,
    /// By class.
    pub lines: Vec<(&'static str, Vec<(f64, f64)>)>,
    pub lanes: Vec<Vec<Segment>>,
    pub flags: Vec<Flag>,
    pub ahead: Option<Extrapolation>,
    pub height: f64,
    /// Whether single points may be drawn at the edge.
    pub clips: bool,
}

impl Chart {
    pub fn new(label: String, caption: Markup, across: XAxis, x: (f64, f64)) -> Self {
        Self { label, caption, across, x, height: 170.0, ..Self::default() }
    }

    fn dots(&self) -> impl Iterator<Item = &DataPoint> {
        self.tracks.iter().flat_map(|track| &track.dots)
    }

    fn envelopes(&self) -> impl Iterator<Item = &[f64; 4]> {
        self.tracks.iter().flat_map(|track| &track.envelope)
    }

    /// How far from zero a point may lie to be drawn where it is.
    fn reach(&self) -> f64 {
        let mut all: Vec<f64> = self.dots().map(|dot| dot.y.abs()).collect();
        all.extend(self.envelopes().map(|[_, low, _, high]| low.abs().max(high.abs())));
        if !self.clips || all.is_empty() {
            return f64::INFINITY;
        }
        all.sort_unstable_by(f64::total_cmp);
        let mut usual = EDGES.into_iter().map(|(part, least, far)| {
            let few = (all.len() / part).max(least);
            far * all.len().checked_sub(few + 1).map_or(0.0, |place| all[place]).max(self.around)
        });
        usual.find(|usual| all[all.len() - 1] > *usual).unwrap_or(f64::INFINITY)
    }

    /// Both ends of the y axis. What is drawn at the edge does not widen it.
    fn ends(&self, reach: f64) -> (f64, f64) {
        if let Some(range) = self.range {
            return range;
        }
        let within = |y: &f64| y.abs() <= reach;
        let bars = self.dots().filter(|dot| within(&dot.y)).flat_map(|dot| {
            let sd = dot.sd.unwrap_or(0.0).min(2.0 * self.around.max(dot.y.abs()));
            [dot.y - sd, dot.y + sd]
        });
        let envelopes = self.envelopes().flat_map(|[_, low, _, high]| [*low, *high]);
        let levels = self.levels.iter().flat_map(|level| {
            let around = LEAST_RANGE * level.budget.unwrap_or(self.around);
            [level.at - around, level.at + around]
        });
        let lines = self.lines.iter().flat_map(|(_, line)| line.iter().map(|(_, y)| *y));
        let all = bars.chain(envelopes.filter(within)).chain(levels).chain(lines);
        let own = [-LEAST_RANGE, LEAST_RANGE].map(|part| part * self.around);
        let own = own.into_iter().filter(|_| self.levels.is_empty() && self.signed);
        match bounds(all.chain(own)) {
            Some(found) => widened(found, 0.04, if self.around > 0.0 { self.around } else { 1.0 }),
            None => (-1.0, 1.0),
        }
    }

    /// The picture; nothing where there is nothing to draw.
    pub fn markup(&self) -> Markup {
        let drawn = self.tracks.iter().any(|track| !track.dots.is_empty() || !track.envelope.is_empty());
        if !drawn || self.x.0 >= self.x.1 {
            return html! {};
        }
        let reach = self.reach();
        let scale = Scale { x: self.x, y: self.ends(reach), height: self.height };
        let lanes = LANE * self.lanes.len() as f64;
        let whole = TOP + self.height + lanes + self.bottom();
        let (from, until) = (place(self.x.0), place(self.x.1));
        html! {
            figure.chart {
                figcaption { (self.caption) }
                div.picture.bare[self.whole.is_none()] role="group" tabindex="0" aria-label=(self.label)
                    data-from=(from) data-until=(until) {
                    svg.axis width=(LEFT) height=(whole) { (self.left(&scale)) }
                    svg.area height=(whole - TOP) {
                        (self.ground(&scale))
                        @for track in &self.tracks { (self.track(&scale, track, reach)) }
                        (self.above(&scale))
                        (self.below(&scale))
                        (self.links(&scale))
                    }
                    @if self.whole.is_some() { svg.axis width="56" height=(whole) { (self.right(&scale)) } }
                }
                output.said.no-print aria-live="polite" {}
            }
        }
    }

    /// Room for the figures of the x axis, and under them for its name.
    fn bottom(&self) -> f64 {
        if matches!(self.across, XAxis::Figure(_)) { BOTTOM + LINE } else { BOTTOM }
    }

    fn left(&self, scale: &Scale) -> Markup {
        let limits: Vec<f64> =
            self.whole.filter(|_| self.signed).into_iter().flat_map(|whole| [whole, -whole, 0.0]).collect();
        let (shown, decimals) = figures_apart(scale.y, self.height, LINE, &limits);
        html! {
            @for figure in shown {
                @let y = place(TOP + scale.y(figure.at) + 4.0);
                @let signed = self.signed && figure.at != 0.0;
                @let plain = format!("{:.decimals$}", figure.at);
                @let text = if signed { format!("{:+.decimals$}", figure.at) } else { plain };
                text.limit[figure.named && figure.at != 0.0] x=(LEFT - 6.0) y=(y) text-anchor="end" { (text) }
            }
        }
    }

    fn right(&self, scale: &Scale) -> Markup {
        let whole = self.whole.unwrap_or(1.0);
        let ends = (scale.y.0 / whole * 100.0, scale.y.1 / whole * 100.0);
        let (shown, decimals) = figures_apart(ends, self.height, LINE, &[100.0, -100.0, 0.0]);
        html! {
            @for figure in shown {
                @let y = place(TOP + scale.y(figure.at * whole / 100.0) + 4.0);
                @let text = if figure.at == 0.0 { "0 %".to_owned() } else { format!("{:+.decimals$} %", figure.at) };
                text.limit[figure.named && figure.at != 0.0] x="5" y=(y) { (text) }
            }
        }
    }

    /// The view of what is stretched to the width of the picture.
    fn stretched(&self) -> String {
        format!("0 0 1000 {}", self.height)
    }

    /// What the points stand before.
    fn ground(&self, scale: &Scale) -> Markup {
        let (figures, _) = round_steps(scale.y, 6.0);
        html! {
            @for level in &self.levels { (self.level(scale, level)) }
            @for figure in figures {
                @let y = place(scale.y(figure));
                line.grid x1="0" x2="100%" y1=(y) y2=(y) {}
            }
            @for flag in &self.flags { @if let Some(until) = flag.until {
                @let (x, width) = scale.stretch(flag.x, until);
                rect.test x=(x) y="0" width=(width) height=(self.height) { title { (flag.label) } }
            } }
            @if let Some(ahead) = &self.ahead { (self.ahead(scale, ahead)) }
            @if !self.lines.is_empty() || self.tracks.iter().any(|track| track.joined || !track.envelope.is_empty()) {
                svg.stretched width="100%" height=(self.height) viewBox=(self.stretched()) preserveAspectRatio="none" {
                    @for track in &self.tracks {
                        @if !track.envelope.is_empty() { (envelope(scale, track)) }
                        @if track.joined { path class={ "join " (track.class) } d=(joined(scale, track)) {} }
                    }
                    @for (class, line) in &self.lines { polyline class=(class) points=(corners(scale, line)) {} }
                }
            }
        }
    }

    fn level(&self, scale: &Scale, level: &Level) -> Markup {
        let (x, width) = scale.stretch(level.from, level.until);
        let (x1, x2) = (scale.x(level.from), scale.x(level.until));
        let between = |half: f64| {
            let (top, bottom) = (scale.y(level.at + half), scale.y(level.at - half));
            (place(top), place(bottom - top))
        };
        let across = |class: &'static str, y: f64| {
            let y = place(scale.y(y));
            html! { line class=(class) x1=(x1) x2=(x2) y1=(y) y2=(y) {} }
        };
        html! {
            @if let Some(shade) = level.shade {
                @let (y, height) = between(shade);
                rect.band x=(x) y=(y) width=(width) height=(height) {}
            }
            @if let Some(budget) = level.budget {
                @let (y, height) = between(budget);
                rect.band x=(x) y=(y) width=(width) height=(height) {}
                @if let Some((from, until)) = level.made {
                    @let (x, width) = scale.stretch(from, until);
                    rect.made x=(x) y=(y) width=(width) height=(height) { title { (level.label) } }
                }
                (across("budget", level.at + budget)) (across("budget", level.at - budget))
            }
            @for limit in level.control.into_iter().flat_map(|control| [level.at - control, level.at + control]) {
                @if (scale.y.0..=scale.y.1).contains(&limit) { (across("control", limit)) }
            }
            (across("level", level.at))
        }
    }

    fn ahead(&self, scale: &Scale, ahead: &Extrapolation) -> Markup {
        let [_, now, _] = ahead.line;
        html! {
            svg.stretched width="100%" height=(self.height) viewBox=(self.stretched()) preserveAspectRatio="none" {
                @if let Some([early, late]) = ahead.cone {
                    polygon.cone points=(corners(scale, &[now, early, late])) {}
                }
                polyline.ahead points=(corners(scale, &ahead.line)) {}
            }
        }
    }

    fn track(&self, scale: &Scale, track: &Track, reach: f64) -> Markup {
        let bars = track.dots.len() <= MOST_BARS;
        // The newest letters first; older ones only where they do not stand in each other's way.
        let mut free = f64::INFINITY;
        let mut lettered = vec![false; track.dots.len()];
        for (k, dot) in track.dots.iter().enumerate().rev() {
            let letters =
                if scale.is_off(dot, reach) { value_of(dot).chars().count() } else { dot.letters.chars().count() };
            let width = LETTER * (letters as f64 + 0.3) / NARROWEST * (self.x.1 - self.x.0);
            if letters > 0 && dot.x + 0.5 * width < free {
                lettered[k] = true;
                free = dot.x - 0.5 * width;
            }
        }
        html! {
            g class=(track.class) {
                @for (dot, lettered) in track.dots.iter().zip(lettered) {
                    (self.dot(scale, dot, lettered, bars, reach))
                }
            }
        }
    }

    fn dot(&self, scale: &Scale, dot: &DataPoint, lettered: bool, bars: bool, reach: f64) -> Markup {
        let x = scale.x(dot.x);
        let class = dot.status.map_or("plain", Status::name);
        if scale.is_off(dot, reach) {
            let up = dot.y > scale.y.1;
            let y = if up { 3.0 } else { self.height - 3.0 };
            let (arrow, at) = if up { ("M0-3l5 8h-10z", 16.0) } else { ("M0 3l5-8h-10z", -9.0) };
            return html! {
                svg.mark x=(x) y=(place(y)) {
                    path class={ "off " (class) } d=(arrow) {}
                    @if lettered { text.halo y=(at) text-anchor=(scale.anchor(dot.x)) { (value_of(dot)) } }
                }
            };
        }
        let y = scale.y(dot.y);
        html! {
            @if let Some(sd) = dot.sd.filter(|_| bars) {
                @let (top, bottom) = (scale.y(dot.y + sd).max(0.0), scale.y(dot.y - sd).min(self.height));
                line.bar x1=(x) x2=(x) y1=(place(top)) y2=(place(bottom)) {}
            }
            @if let Some(status) = dot.status.filter(|status| *status > Status::InTolerance) {
                svg.mark x=(x) y=(place(y)) {
                    path class=(class) d=(sign(status)) {}
                    @if lettered { text.letters.halo y="-8" text-anchor="middle" { (dot.letters) } }
                }
            } @else { circle class=(class) cx=(x) cy=(place(y)) r="3" {} }
        }
    }

    /// At the foot of the budget; where points are in the way under its head, or beyond either.
    fn place_of_label(&self, level: &Level, scale: &Scale) -> f64 {
        let Some(budget) = level.budget else { return self.height - 4.0 };
        let (foot, head) = (scale.y(level.at - budget), scale.y(level.at + budget));
        let places = [foot - 4.0, head + LINE, foot + 2.0 * LINE, head - LINE];
        let places = places.map(|y| y.clamp(LINE, self.height - 2.0));
        let long = wide(&level.label) / NARROWEST * (self.x.1 - self.x.0);
        let stretch = if scale.share(level.from) > 0.5 {
            level.until - long..=level.until
        } else {
            level.from..=level.from + long
        };
        let is_free = |label: &f64| {
            let is_near = |dot: &DataPoint| (label - LINE / 2.0 - scale.y(dot.y)).abs() < LINE;
            !self.dots().any(|dot| stretch.contains(&dot.x) && is_near(dot))
        };
        places.into_iter().find(is_free).unwrap_or(places[0])
    }

    /// Stretches of lanes of which nowhere in the picture all of the name is to be read, however narrow it is.
    pub fn unnamed(&self) -> Vec<&Segment> {
        let is_named = |segment: &&Segment| self.room(segment, NARROWEST);
        let mut found: Vec<&Segment> = Vec::new();
        for lane in &self.lanes {
            for segment in lane {
                let same = |other: &&Segment| other.kind == segment.kind;
                let is_known = found.iter().any(|other| other.label == segment.label);
                if !is_known && !lane.iter().filter(same).any(|one| is_named(&one)) {
                    found.push(segment);
                }
            }
        }
        found
    }

    /// Whether the name of a stretch fits into it where the picture is as wide as that.
    fn room(&self, segment: &Segment, width: f64) -> bool {
        let share = (segment.until - segment.from) / (self.x.1 - self.x.0);
        share * width >= 0.88 * wide(&segment.label) + 4.0
    }

    /// What stands over the points: names of the lines, flags.
    fn above(&self, scale: &Scale) -> Markup {
        let newest = self.levels.last();
        html! {
            @if let Some((level, control)) = newest.and_then(|level| Some((level, level.control?))) {
                // Outside of the limits, where fewer points stand.
                @for (name, limit, beside) in [("UCL", level.at + control, -3.0), ("LCL", level.at - control, 10.0)] {
                    @if (scale.y.0..=scale.y.1).contains(&limit) {
                        text.halo x="100%" dx="-3" y=(place(scale.y(limit) + beside)) text-anchor="end" { (name) }
                    }
                }
            }
            @for level in &self.levels {
                @let wide = (level.until - level.from) / (self.x.1 - self.x.0);
                @if !level.label.is_empty() && wide > 0.012 * level.label.chars().count() as f64 {
                    @let y = place(self.place_of_label(level, scale));
                    // To the left of the end where it would run over the axis.
                    @if scale.share(level.from) > 0.5 { text.halo x="100%" dx="-3" y=(y) text-anchor="end" { (level.label) } }
                    @else { text.halo x=(scale.x(level.from)) dx="3" y=(y) { (level.label) } }
                }
            }
            @for flag in &self.flags {
                a.flag href={ "#" (flag.anchor) } tabindex="-1" {
                    title { (flag.label) }
                    svg.mark x=(scale.x(flag.x)) y="0" {
                        line y1="-13" y2=(self.height) {}
                        path d="M0-13h13v10h-13z" {}
                        text x="6.5" y="-5" text-anchor="middle" { (flag.number) }
                    }
                }
            }
        }
    }

    /// Under the points: lanes, and the figures of the x axis.
    fn below(&self, scale: &Scale) -> Markup {
        let foot = self.height + LANE * self.lanes.len() as f64 + 14.0;
        html! {
            @for (k, lane) in self.lanes.iter().enumerate() {
                @let y = self.height + 3.0 + LANE * k as f64;
                @for segment in lane {
                    @let (x, width) = scale.stretch(segment.from, segment.until);
                    svg.lane x=(x) y=(place(y)) width=(width) height=(LANE - 3.0) {
                        title { (segment.label) }
                        rect class={ "lane" (segment.kind % 6) } width="100%" height="100%" {}
                        @if self.room(segment, DESK) {
                            text.roomy[!self.room(segment, NARROWEST)] x="3" y="9.5" { (segment.label) }
                        }
                    }
                }
            }
            @match &self.across {
                XAxis::Time => @for (x, label) in dates(self.x) {
                    line.tick x1=(scale.x(x)) x2=(scale.x(x)) y1=(self.height) y2=(self.height + 3.0) {}
                    text.date x=(scale.x(x)) y=(foot) text-anchor=(scale.anchor(x)) { (label) }
                },
                XAxis::Figure(name) => {
                    @let (figures, decimals) = round_steps(self.x, 6.0);
                    @let words: Vec<String> = figures.iter().map(|x| format!("{x:.decimals$}")).collect();
                    // As many as stand beside one another in the narrowest picture.
                    @let every = (words.iter().map(|word| wide(word) + LETTER).sum::<f64>() / NARROWEST).ceil().max(1.0);
                    @for (k, (x, word)) in figures.into_iter().zip(words).enumerate() {
                        line.tick x1=(scale.x(x)) x2=(scale.x(x)) y1=(self.height) y2=(self.height + 3.0) {}
                        @if k % every as usize == 0 {
                            text x=(scale.x(x)) y=(foot) text-anchor=(scale.anchor(x)) { (word) }
                        }
                    }
                    text x="100%" y=(foot + LINE) text-anchor="end" { (name) }
                }
            }
        }
    }

    /// Of each place that a pointer tells from the next the point that matters most, with its words.
    fn links(&self, scale: &Scale) -> Markup {
        let width = (self.x.1 - self.x.0) / COLUMNS;
        let mut shown: Vec<&DataPoint> = Vec::new();
        let mut all: Vec<&DataPoint> = self.dots().filter(|dot| !dot.said.is_empty()).collect();
        all.sort_by(|a, b| a.x.total_cmp(&b.x));
        let weight = |dot: &DataPoint| (dot.status.filter(|status| *status >= Status::Drifting), dot.y.abs());
        for dot in all {
            match shown.last_mut() {
                Some(last) if dot.x - last.x < width && (dot.y - last.y).abs() < (scale.y.1 - scale.y.0) / 20.0 => {
                    if weight(dot) >= weight(last) {
                        *last = dot;
                    }
                }
                _ => shown.push(dot),
            }
        }
        html! {
            @for dot in shown {
                @let y = place(scale.y(dot.y));
                a.point href=[dot.href.as_deref()] tabindex="-1" {
                    title { (dot.said) } circle cx=(scale.x(dot.x)) cy=(y) r="8" {}
                }
            }
        }
    }
}

/// From figures to places in a picture.
struct Scale {
    x: (f64, f64),
    y: (f64, f64),
    height: f64,
}

impl Scale {
    /// Whether a point stands at the edge, with its value.
    fn is_off(&self, dot: &DataPoint, reach: f64) -> bool {
        dot.y.abs() > reach || dot.y < self.y.0 || dot.y > self.y.1
    }

    fn share(&self, x: f64) -> f64 {
        ((x - self.x.0) / (self.x.1 - self.x.0)).clamp(0.0, 1.0)
    }

    fn x(&self, x: f64) -> String {
        format!("{:.2}%", 100.0 * self.share(x))
    }

    /// How a text stands at `x`: half of it does not fit beyond an end.
    fn anchor(&self, x: f64) -> &'static str {
        match self.share(x) {
            share if share < 0.06 => "start",
            share if share > 0.94 => "end",
            _ => "middle",
        }
    }

    /// From and width.
    fn stretch(&self, from: f64, until: f64) -> (String, String) {
        let width = 100.0 * (self.share(until) - self.share(from));
        (self.x(from), format!("{:.2}%", width.max(0.2)))
    }

    fn y(&self, y: f64) -> f64 {
        let share = (y - self.y.0) / (self.y.1 - self.y.0);
        self.height * (1.0 - share.clamp(0.0, 1.0))
    }
}

/// Area of the narrowest picture, and of one of two beside one another on a desk, where the style sheet shows what is
/// `roomy`; and a letter of a rule in it, pixels.
const NARROWEST: f64 = 225.0;
const DESK: f64 = 448.0;
const LETTER: f64 = 7.0;

/// Pixels that a text under an axis takes, roughly: Chinese letters are twice as wide.
fn wide(text: &str) -> f64 {
    text.chars().map(|c| if c.is_ascii() { 6.2 } else { 11.0 }).sum()
}

/// Corners of a line in a part that is stretched to the picture's width.
fn corners(scale: &Scale, line: &[(f64, f64)]) -> String {
    line.iter().map(|(x, y)| format!("{:.1},{:.1} ", 1000.0 * scale.share(*x), scale.y(*y))).collect()
}

/// From point to point; a new level begins a new line, for one across would connect two gyros.
fn joined(scale: &Scale, track: &Track) -> String {
    let mut text = String::with_capacity(12 * track.dots.len());
    let mut last = f64::NEG_INFINITY;
    for dot in &track.dots {
        let begins = text.is_empty() || track.breaks.iter().any(|at| last < *at && *at <= dot.x);
        let (x, y) = (1000.0 * scale.share(dot.x), scale.y(dot.y));
        write!(text, "{}{x:.1} {y:.1}", if begins { 'M' } else { 'L' }).expect("writing to a string cannot fail");
        last = dot.x;
    }
    text
}

/// From the lowest to the highest of each stretch, and the line of the medians.
fn envelope(scale: &Scale, track: &Track) -> Markup {
    let there = track.envelope.iter().map(|[x, low, ..]| (*x, *low));
    let back = track.envelope.iter().rev().map(|[x, _, _, high]| (*x, *high));
    let median: Vec<(f64, f64)> = track.envelope.iter().map(|[x, _, median, _]| (*x, *median)).collect();
    html! {
        polygon.envelope points=(corners(scale, &there.chain(back).collect::<Vec<_>>())) {}
        polyline.median points=(corners(scale, &median)) {}
    }
}

pub(super) fn bounds(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |bounds, v| bounds.map_or(Some((v, v)), |(a, b): (f64, f64)| Some((a.min(v), b.max(v)))))
}

/// By a share on either side; where there is no width, by `least`.
pub(super) fn widened((a, b): (f64, f64), share: f64, least: f64) -> (f64, f64) {
    let edge = (share * (b - a)).max(if b > a { 0.0 } else { least });
    (a - edge, b + edge)
}

pub(super) fn millis(at: UtcMicros) -> f64 {
    at.0.div_euclid(1000) as f64
}

/// A tenth of a pixel is enough.
fn place(pixels: f64) -> String {
    let text = format!("{pixels:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// Three digits of it, with its sign.
fn value_of(dot: &DataPoint) -> String {
    let power = 10_f64.powf(2.0 - dot.y.abs().max(1e-12).log10().floor());
    format!("{:+}", (dot.y * power).round() / power)
}

#[cfg(test)]
mod tests;
