//! What the truth itself says about names: how much of a hidden cause's response the free coefficients of an effect
//! can reproduce in this campaign. One effect's columns come from the simulator's physics, one coefficient at a time.

use crate::simulate::Simulated;
use crate::simulate::cause::{ALWAYS, COMMON, Cause, CauseKind, Mechanism};
use crate::simulate::detectability::{Sight, extend, norm, without};
use crate::simulate::world::World;

/// The structure that a campaign holds, and what is left of it as effects are named.
pub struct Structure<'a> {
    world: &'a World,
    causes: &'a [Cause],
    sights: Vec<Sight>,
    /// Noise-free outputs without any cause, gyro by gyro.
    plain: Vec<Vec<f64>>,
    /// Directions already explained, over all gyros end to end.
    explained: Vec<Vec<f64>>,
    /// Whitened response of all causes off the model's columns, over all gyros end to end.
    response: Vec<f64>,
}

impl<'a> Structure<'a> {
    /// Of a simulated campaign and all its causes.
    pub fn of(simulated: &'a Simulated) -> Self {
        Self::of_causes(&simulated.world, &simulated.causes)
    }

    /// The structure of some of a campaign's causes.
    pub fn of_causes(world: &'a World, causes: &'a [Cause]) -> Self {
        let sights: Vec<Sight> = world.sd.iter().map(|sd| Sight::new(world.terms, &world.commanded, sd)).collect();
        let mut structure =
            Self { world, causes, sights, plain: world.outputs(&[]), explained: Vec::new(), response: Vec::new() };
        structure.response = structure.whitened(causes).concat();
        structure
    }

    /// d of what no named effect reproduces yet.
    pub fn left(&self) -> f64 {
        norm(&without(&self.explained, self.response.clone()))
    }

    /// d that would be left if `effect` were named in `slots`, with the best of its shapes; none for an unknown id.
    pub fn left_with(&self, effect: &str, slots: &[String]) -> Option<f64> {
        self.best(effect, slots).map(|(left, _)| left)
    }

    /// Names `effect` in `slots`: its columns can explain from now on.
    pub fn name(&mut self, effect: &str, slots: &[String]) {
        if let Some((_, explained)) = self.best(effect, slots) {
            self.explained = explained;
        }
    }

    fn best(&self, effect: &str, slots: &[String]) -> Option<(f64, Vec<Vec<f64>>)> {
        let shapes = self.shapes(effect)?;
        // The right name explains its cause at its size: a strong rotation is not linear in it.
        let is_hidden = |cause: &&Cause| cause.label == effect && cause.acts_in_h == ALWAYS;
        let hidden: Vec<Vec<f64>> =
            self.causes.iter().filter(is_hidden).flat_map(|cause| self.columns(cause, slots)).collect();
        let tried = shapes.into_iter().map(|coefficients| {
            let mut basis = self.explained.clone();
            let units = coefficients.into_iter().map(|kind| unit(effect, kind));
            let columns = units.flat_map(|unit| self.columns(&unit, slots)).chain(hidden.iter().cloned());
            columns.for_each(|column| extend(&mut basis, column));
            (norm(&without(&basis, self.response.clone())), basis)
        });
        tried.min_by(|(a, _), (b, _)| a.total_cmp(b))
    }

    /// Columns of one cause: one for a common effect, else one a gyro.
    fn columns(&self, cause: &Cause, slots: &[String]) -> Vec<Vec<f64>> {
        let each = self.whitened(std::slice::from_ref(cause));
        if COMMON.contains(&cause.label.as_str()) {
            return vec![each.concat()];
        }
        let named = |j: usize| slots.iter().any(|slot| slot == self.world.gyros[j].slot.name());
        (0..each.len())
            .filter(|&j| named(j))
            .map(|j| {
                let alone = |k: usize| if k == j { each[k].clone() } else { vec![0.0; each[k].len()] };
                (0..each.len()).flat_map(alone).collect()
            })
            .collect()
    }

    fn whitened(&self, causes: &[Cause]) -> Vec<Vec<f64>> {
        let with = self.world.outputs(causes);
        with.iter()
            .zip(&self.plain)
            .zip(&self.sights)
            .map(|((with, plain), sight)| {
                let response: Vec<f64> = with.iter().zip(plain).map(|(a, b)| a - b).collect();
                sight.left_over(&response)
            })
            .collect()
    }

    /// Alternatives of an effect, each with one member for every free coefficient.
    fn shapes(&self, effect: &str) -> Option<Vec<Vec<Mechanism>>> {
        let span_h = self.world.mid_h().last().copied()?;
        Mechanism::alternatives(effect, span_h, self.world.plan.len(), &self.true_times())
    }

    /// Time constants and periods of the hidden causes themselves, so that a right name explains all.
    fn true_times(&self) -> Vec<f64> {
        let time = |cause: &Cause| match &cause.kind {
            CauseKind::Catalogue(effect) => effect.own_time_h(),
            CauseKind::Uncatalogued(_) => None,
        };
        self.causes.iter().filter_map(time).collect()
    }
}

/// One coefficient of an effect, small enough to be linear.
fn unit(effect: &str, kind: Mechanism) -> Cause {
    Cause { label: effect.into(), size: 1e-6, weights: [1.0; 3], kind: CauseKind::Catalogue(kind), acts_in_h: ALWAYS }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::scenario::{EffectChoice, Scenario};
    use crate::simulate::simulate;

    fn all() -> Vec<String> {
        ["G1", "G2", "G3"].map(str::to_owned).to_vec()
    }

    fn hidden(effects: &[&str]) -> Simulated {
        hidden_at(12.0, effects)
    }

    fn hidden_at(d: f64, effects: &[&str]) -> Simulated {
        let mut scenario = Scenario::default();
        scenario.programme.positions = crate::simulate::programme::Positions::WithTilts;
        scenario.effects = effects.iter().map(|e| EffectChoice::detectable(e, d)).collect();
        simulate(&scenario).unwrap()
    }

    #[test]
    fn the_right_name_explains_everything_and_an_unrelated_one_nearly_nothing() {
        for id in ["temperature_g", "warmup", "levelling", "periodic", "magnetic", "bias_step", "cross_compliance"] {
            let simulated = hidden(&[id]);
            let structure = Structure::of(&simulated);
            assert!((structure.left() - 12.0).abs() < 1e-3, "{id}");
            assert!(structure.left_with(id, &all()).unwrap() < 0.02, "{id}: {:?}", structure.left_with(id, &all()));
            assert!(structure.left_with("scale_cubic", &all()).unwrap() > 10.0, "{id}");
        }
    }

    #[test]
    fn the_right_name_explains_a_strong_rotation_as_well() {
        for id in ["levelling", "azimuth"] {
            let simulated = hidden_at(1000.0, &[id]);
            let left = Structure::of(&simulated).left_with(id, &all()).unwrap();
            assert!(left < 0.02, "{id}: {left}");
        }
    }

    #[test]
    fn a_name_in_the_wrong_gyro_explains_nothing_there() {
        let simulated = hidden(&["time_ramp"]);
        let own = simulated.truth.seen_by[0]["G2"];
        let left = Structure::of(&simulated).left_with("time_ramp", &["G1".into(), "G3".into()]).unwrap();
        assert!((left - own).abs() < 1e-6);
    }

    #[test]
    fn two_causes_are_explained_one_after_the_other() {
        let simulated = hidden(&["hysteresis", "scale_quadratic"]);
        let mut structure = Structure::of(&simulated);
        let both = structure.left();
        structure.name("hysteresis", &all());
        let one = structure.left();
        structure.name("scale_quadratic", &all());
        assert!(both > one && one > 8.0 && structure.left() < 1e-3, "{both} {one} {}", structure.left());
    }
}
