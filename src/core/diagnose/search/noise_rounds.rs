//! The search made consistent with the noise it assumes, where the station stated none.
//!
//! Noise that grows with rate and an effect of rate can pass for one another. The growth is found again with what was
//! adopted in the model, the search is run again where it moved, and what was adopted must earn its place with the
//! growth averaged out, not only at its best value.

use std::cell::OnceCell;
use std::rc::Rc;

use crate::core::calibrate::growth::NoiseGrowth;
use crate::core::calibrate::law;
use crate::core::diagnose::diagnosis::Variable;
use crate::core::diagnose::residuals::augmented_fit::{self, Part};
use crate::core::diagnose::residuals::noise_growth::{GROWTHS, profile};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::choice::{Choice, designs, without};
use crate::core::diagnose::search::components::{Component, components, evidence_of, of_single_dwells};
use crate::core::diagnose::search::hypotheses::{Bank, Candidates};
use crate::core::diagnose::search::noise_models::{Found, NoiseModels, likelier_law};
use crate::core::diagnose::search::null_distribution::Null;
use crate::core::diagnose::search::projections::each_by_itself;
use crate::core::diagnose::search::refined_shape::sharpened;
use crate::core::diagnose::search::stepwise::{Known, Search, Threshold};
use crate::core::effects::{Effect, Entry, Refusal, Shape};
use crate::core::numerics::basis::dot;
use crate::core::numerics::log_sum::LogSum;

/// Probability with which noise alone may get anything named.
pub const FALSE_ALARM: f64 = 0.0095;

/// Probability with which noise may get anything named beside a name.
const FALSE_ALARM_BESIDE: f64 = 0.005;

/// The search is run at most this often with other growths of the noise.
const ROUNDS: usize = 4;

/// Steps of the growth's grid by which a search that found nothing lowers it: an effect that is not in the model yet
/// looks like growing noise and hides in it.
const LOWER: usize = 2;

/// ln of evidence from which on an effect is strong: what hangs on its size is then fitted about it.
const STRONG: f64 = 60.0;

pub(crate) struct SearchOutcome {
    pub frame: Frame,
    pub bank: Bank,
    pub null: Null,
    pub threshold: Threshold,
    known: Known,
    pub found: Vec<Choice>,
    /// Shapes of the bank beyond the grid.
    more: Vec<(Effect, Shape)>,
    noise: NoiseModels,
    /// What the noise is, with what was found in the model.
    pub noise_found: Found,
    /// How it goes beside what is stated.
    pub laws: Vec<law::Law>,
    /// Whether a name fell because its cause has another form.
    another_form: bool,
    /// Of what the dwells are, whatever their noise is.
    components: Rc<OnceCell<Vec<Component>>>,
}

impl SearchOutcome {
    /// Searches, and again while what was found asks for another growth of the noise with rate; at most four times.
    ///
    /// # Errors
    /// As a frame with other noise.
    pub fn of(mut frame: Frame) -> Result<Self, Refusal> {
        let mut first = None;
        for round in 1.. {
            let bank = Bank::of(&frame, &Candidates::of(&frame, &[]));
            let null = Null::of(&frame, &bank);
            let threshold =
                Threshold { alone: null.threshold(FALSE_ALARM), beside: null.threshold(FALSE_ALARM_BESIDE) };
            let mut settled = Self::before_search(frame, bank, null, threshold);
            let mut found = settled.search().run();
            // A handful of shapes more: what noise alone scores is as good as the same.
            let sharper = sharpened(&settled.search(), &found);
            if !sharper.is_empty() {
                settled.bank = Bank::of(&settled.frame, &Candidates::of(&settled.frame, &sharper));
                (settled.more, settled.known) = (sharper, Known::default());
                found = settled.search().run();
            }
            let next = settled.frame.noise.law.and_then(|law| {
                found = confirmed(&settled.search(), law, std::mem::take(&mut found));
                next_growth(&settled.frame, &settled.bank, &found, law)
            });
            let empty = found.is_empty();
            settled.found = found;
            match next.filter(|_| round < ROUNDS) {
                Some(growth) => frame = settled.frame.with_growth(growth)?,
                None if empty => return Ok(first.unwrap_or(settled)),
                None => return Ok(settled),
            }
            // Where nothing is ever found, the first look with the likeliest noise is the answer.
            if empty {
                first.get_or_insert(settled);
            }
        }
        unreachable!("the last round returns")
    }

    /// With nothing found yet, and no noise but that of `frame`.
    fn before_search(frame: Frame, bank: Bank, null: Null, threshold: Threshold) -> Self {
        Self {
            frame,
            bank,
            null,
            threshold,
            known: Known::default(),
            found: Vec::new(),
            more: Vec::new(),
            noise: NoiseModels::default(),
            noise_found: Found::default(),
            laws: Vec::new(),
            another_form: false,
            components: Rc::default(),
        }
    }

    /// `plain`, the campaign as it is, about the strong effects: those among what was found, or one that is
    /// not linear in their place, where that leaves less (Schwarz's criterion). With its axes off, a rotation may pass
    /// for a field.
    pub fn about_strong(&self, plain: &Frame) -> Result<Option<(Vec<Part>, Frame)>, Refusal> {
        let search = self.search();
        let named = self.found.iter().filter(|choice| !choice.is_competitor());
        let strong: Vec<Part> = named.filter(|c| c.evidence > STRONG).filter_map(|c| search.part(c)).collect();
        let alone = search.scores(&[]);
        let curved = alone.iter().filter(|s| s.log_evidence > STRONG && s.kind.entry().beyond.is_some());
        let curved = curved.filter_map(|score| Some(vec![search.part(&search.choice(score))?]));
        let mut best: Option<(f64, Vec<Part>, Frame)> = None;
        let tried = curved.chain([strong]).filter(|parts| !parts.is_empty());
        for (parts, all_orders) in tried.flat_map(|parts| [(parts.clone(), true), (parts, false)]) {
            let frame = plain.about(&parts, all_orders)?;
            let fit = augmented_fit::fit(&frame, &parts);
            let n = frame.dwells() as f64;
            let left = fit.residuals.iter().map(|r| n * dot(r, r).ln()).sum::<f64>() + fit.fitted.len() as f64 * n.ln();
            if best.as_ref().is_none_or(|(least, ..)| left < *least) {
                best = Some((left, parts, frame));
            }
        }
        Ok(best.map(|(_, parts, frame)| (parts, frame)))
    }

    /// Whether something of what the search saw holds over all that the noise may be.
    pub fn stands(&self) -> bool {
        self.another_form || !self.found.is_empty()
    }

    /// The search as it was run last.
    pub fn search(&self) -> Search<'_> {
        let (frame, bank, null, known) = (&self.frame, &self.bank, &self.null, &self.known);
        Search { frame, bank, null, threshold: self.threshold, known, noise: &self.noise }
    }

    /// The search once more where something is named or a gap is seen: with all that the noise may be, and against
    /// suspects that are not worth their time elsewhere.
    pub fn closer(&self) -> Result<Self, Refusal> {
        let (mut laws, mut rebased) = (Vec::new(), None::<Self>);
        while laws.len() < MOST_LAWS {
            let now = rebased.as_ref().unwrap_or(self);
            let Some((gain, law, frame)) = likelier_law(&now.frame, &now.columns()) else { break };
            // Scatter that goes with something is no noise.
            if now.likeliest_component() > gain {
                break;
            }
            laws.push(law);
            rebased = Some(Self { components: Rc::clone(&self.components), ..Self::of(frame)? });
        }
        // What seems to follow a law may be what a suspect explains.
        let as_stated = self.among_suspects(Vec::new());
        let is_explained = || likelier_law(&self.frame, &as_stated.columns()).is_none();
        Ok(match rebased {
            Some(by_laws) if !(as_stated.found.iter().any(Choice::is_competitor) && is_explained()) => {
                by_laws.among_suspects(laws)
            }
            _ => as_stated,
        })
    }

    /// The search once more against suspects, where the noise goes by `laws`.
    fn among_suspects(&self, laws: Vec<law::Law>) -> Self {
        let candidates = Candidates::closer(&self.frame, &self.more);
        let mut closer = Self {
            noise: NoiseModels::of(&self.frame, &self.bank, &self.found, &candidates),
            more: self.more.clone(),
            laws,
            components: Rc::clone(&self.components),
            ..Self::before_search(
                self.frame.clone(),
                Bank::of(&self.frame, &candidates),
                self.null.clone(),
                self.threshold,
            )
        };
        if !self.found.is_empty() {
            let search = closer.search();
            let mut found = search.run();
            if let Some(law) = closer.frame.noise.law {
                found = confirmed(&search, law, found);
            }
            closer.found = found;
        }
        closer.noise_found = closer.noise_beside();
        let slow = |entry: &Entry| entry.follows_time || entry.of_temperature;
        while let Some(more) = closer.asked_by_memory()
            && let Some(weakest) = closer.weakest(slow, more)
        {
            closer.found.remove(weakest);
            closer.noise_found = closer.noise_beside();
        }
        while closer.noise_found.may_go_with_rate
            && let Some(weakest) = closer.weakest(|entry| !entry.follows_time, WHERE_OTHER_NOISE_MAY_BE)
        {
            closer.found.remove(weakest);
            closer.noise_found = closer.noise_beside();
        }
        while !closer.laws.is_empty()
            && let Some(weakest) = closer.weakest(|_| true, UNDER_OTHER_NOISE)
        {
            closer.found.remove(weakest);
        }
        while let Some(of_another_form) = closer.of_another_form() {
            closer.found.remove(of_another_form);
            closer.another_form = true;
        }
        closer
    }

    /// ln of the odds that the residuals beside what was found go with some component, of which each is as likely,
    /// taken at the best of them.
    fn likeliest_component(&self) -> f64 {
        let all = self.components();
        let state = each_by_itself(&self.frame, self.search().extras(&self.found));
        let evidence = all.iter().map(|component| component.evidence(&self.frame, &state));
        let alternatives: f64 = all.iter().map(Component::share).sum();
        evidence.fold(of_single_dwells(&state), f64::max) - (alternatives + 1.0).ln()
    }

    /// Probability, at most, that residuals of noise alone go with some variable as much as those beside what was found
    /// do: the mean of a Bayes factor is one under noise, so that it is b or more once in b (Markov's inequality).
    pub fn p_value_of_components(&self) -> f64 {
        (-self.likeliest_component()).exp().min(1.0)
    }

    fn components(&self) -> &[Component] {
        self.components.get_or_init(|| components(&self.frame.setting))
    }

    /// Raw columns of the model and of what was found.
    fn columns(&self) -> Vec<Vec<Vec<f64>>> {
        designs(&self.frame, &self.bank, &self.found)
    }

    fn noise_beside(&self) -> Found {
        let columns = self.columns();
        let state = || each_by_itself(&self.frame, self.search().extras(&self.found));
        self.noise.found(&self.frame, &columns, state)
    }
}

/// Laws of the noise that the standard errors may leave out at once: of duration, of rate and of time.
const MOST_LAWS: usize = 3;

/// ln of evidence by which a component must lead a name for the name to fall.
const LEAD_OF_COMPONENT: f64 = 4.5;

/// And the share of the name's own evidence beside that: what a strong effect's shape misses is some hundredths of it.
const LEAD_SHARE: f64 = 0.03;

/// ln of evidence from which on what is left is described, and by how many variables.
const LEAST_DESCRIBED: f64 = 2.0;
/// The same where two variables act together, and of a few dwells alone: there are more of those.
const LEAST_TOGETHER: f64 = 4.0;
const MOST_DESCRIBED: usize = 2;

/// ln of evidence that a name needs more where the noise departs from what is stated, which is known from the same
/// residuals: a name in time or temperature where the noise has a memory, any name where it follows a law.
const UNDER_OTHER_NOISE: f64 = 4.0;

/// The same of a name in time or temperature where the residuals beside it do not rule out a memory, and of any other
/// where noise may go with rate.
const WHERE_OTHER_NOISE_MAY_BE: f64 = 1.5;

impl SearchOutcome {
    /// The name that a component leads by most, where one leads clearly: the cause has another form.
    fn of_another_form(&self) -> Option<usize> {
        let found = &self.found;
        let lead = |i: usize| {
            let others = without(found, i);
            let state = each_by_itself(&self.frame, self.search().extras(&others));
            let best = (self.components().iter())
                .filter(|c| c.competes)
                .map(|c| c.evidence(&self.frame, &state))
                .fold(f64::NEG_INFINITY, f64::max);
            let columns = |j: usize| {
                let of_name = self.bank.columns_of(found[i].hypothesis, j);
                of_name.map(|column| column.iter().copied().collect()).collect()
            };
            let alike = evidence_of(&self.frame, &state, columns);
            let own = self.search().against_white_noise(&others, found[i].kind).max(alike);
            best - own - LEAD_SHARE * own.max(0.0)
        };
        let named = (0..found.len()).filter(|&i| found[i].kind.is_nameable());
        let leads = named.map(|i| (i, lead(i))).filter(|(_, lead)| *lead > LEAD_OF_COMPONENT);
        leads.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// What the residuals go with beside those of the choices that are named, the strongest first: each variable by its
    /// best component.
    pub fn described(&self, is_named: impl Fn(Effect, Shape) -> bool) -> Vec<(Variable, f64)> {
        let found = self.found.iter();
        let named = found.filter(|c| is_named(c.kind, self.bank.hypotheses[c.hypothesis].shape)).cloned();
        let state = each_by_itself(&self.frame, self.search().extras(&named.collect::<Vec<_>>()));
        let mut best: Vec<(Variable, f64)> = Vec::new();
        for component in self.components() {
            let evidence = component.evidence(&self.frame, &state);
            match best.iter_mut().find(|(variable, _)| *variable == component.variable) {
                Some(held) => held.1 = held.1.max(evidence),
                None => best.push((component.variable, evidence)),
            }
        }
        best.push((Variable::SingleDwells, of_single_dwells(&state)));
        let least = |variable: Variable| match variable {
            Variable::TimeAndForce
            | Variable::TimeAndRate
            | Variable::TimeAndHeading
            | Variable::TemperatureAndForce
            | Variable::TemperatureAndRate
            | Variable::TemperatureAndHeading
            | Variable::TemperatureAndTime
            | Variable::SingleDwells => LEAST_TOGETHER,
            _ => LEAST_DESCRIBED,
        };
        best.retain(|(variable, evidence)| *evidence > least(*variable));
        best.sort_by(|a, b| b.1.total_cmp(&a.1));
        best.truncate(MOST_DESCRIBED);
        best
    }

    /// ln of evidence that a name in time or temperature needs more.
    fn asked_by_memory(&self) -> Option<f64> {
        match &self.noise_found {
            Found { memory: Some(_), .. } => Some(UNDER_OTHER_NOISE),
            found => found.may_have_memory.then_some(WHERE_OTHER_NOISE_MAY_BE),
        }
    }

    /// The least of the names asked about that do not pass by `more` evidence, as noise beyond what is stated asks for.
    fn weakest(&self, asked: impl Fn(&Entry) -> bool, more: f64) -> Option<usize> {
        let (search, found) = (self.search(), &self.found);
        let lead = |i: usize| search.earned_beside_others(found, i) - search.needed(&without(found, i)) - more;
        let named = (0..found.len()).filter(|&i| found[i].kind.is_nameable() && asked(found[i].kind.entry()));
        let weak = named.map(|i| (i, lead(i))).filter(|(_, lead)| *lead < 0.0);
        weak.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }
}

/// Drops what owes its evidence to one value of the growth: ln of the ratio of mean to value at that of `law`, with the
/// choice and without it, is added to its evidence.
fn confirmed(search: &Search, law: NoiseGrowth, mut found: Vec<Choice>) -> Vec<Choice> {
    let frame = search.frame;
    let Some(at) = GROWTHS.iter().position(|growth| *growth == law.growth) else { return found };
    let excess = |designs: &[Vec<Vec<f64>>]| {
        let profile = profile(&frame.setting, &frame.outputs, designs, law.fall);
        LogSum::of(&profile).log_mean(profile.len()) - profile[at]
    };
    loop {
        let with_all = excess(&designs(frame, search.bank, &found));
        let mut weakest: Option<(usize, f64)> = None;
        for i in 0..found.len() {
            let without_it = excess(&designs(frame, search.bank, &without(&found, i)));
            found[i].evidence = search.earned_beside_others(&found, i) + with_all - without_it;
            // What stands beside a name keeps it in doubt.
            let asked = found[i].kind.is_nameable() || !found.iter().any(|choice| choice.kind.is_nameable());
            if asked
                && found[i].evidence < search.needed(&without(&found, i))
                && weakest.is_none_or(|(_, e)| found[i].evidence < e)
            {
                weakest = Some((i, found[i].evidence));
            }
        }
        let Some((i, _)) = weakest else { return found };
        found.remove(i);
    }
}

/// The growth to search with next: the likeliest with what was found, a lower one where nothing was found.
fn next_growth(frame: &Frame, bank: &Bank, found: &[Choice], law: NoiseGrowth) -> Option<f64> {
    let at = GROWTHS.iter().position(|growth| *growth == law.growth)?;
    if found.is_empty() {
        return (at > 0).then(|| GROWTHS[at.saturating_sub(LOWER)]);
    }
    let profile = profile(&frame.setting, &frame.outputs, &designs(frame, bank, found), law.fall);
    let best = (0..GROWTHS.len()).max_by(|&a, &b| profile[a].total_cmp(&profile[b]))?;
    (profile[best] > profile[at] + 0.5).then_some(GROWTHS[best])
}
