//! `--hypothesis`: files with hypotheses of one's own.

use crate::cli::prelude::*;
use crate::core::augmented::AugmentedModel;
use crate::core::campaign::Campaign;
use crate::core::effects::{Effect, MissingInput, axes};
use crate::wire::hypothesis::{parse_toml, with_one_id_each};

/// The hypotheses in the files; beside what a model holds already, each has an id of its own or is the very same.
pub fn files(paths: &[PathBuf], in_use: &AugmentedModel) -> anyhow::Result<Vec<Effect>> {
    let read = |path: &PathBuf| parse_toml(&document::read(path)?).with_context(|| document::name(path));
    let effects = paths.iter().map(read).collect::<anyhow::Result<Vec<Effect>>>()?;
    with_one_id_each(&effects).context("--hypothesis")?;
    let held = in_use.effects.iter().map(|known| known.adopted.effect);
    if let Some(other) = held.into_iter().find(|held| effects.iter().any(|e| e.id() == held.id() && e != held)) {
        bail!(said(message!("hypothesis_of_model", id = other.id())));
    }
    Ok(effects)
}

/// Refuses a campaign in which an equation has no finite value: who asks for it is to know that it was not tried.
pub fn defined_in(effects: &[Effect], campaign: &Campaign) -> anyhow::Result<()> {
    let Ok((setting, _)) = axes::setting(campaign) else { return Ok(()) };
    for effect in effects {
        if let Some(lack @ MissingInput::NotFinite { dwell }) = (effect.entry().missing)(&setting) {
            bail!(said(message!(
                "hypothesis_undefined",
                id = effect.id(),
                lack = lack.message(),
                place = format!("/dwells/{dwell}"),
                equation = effect.entry().equation
            )));
        }
    }
    Ok(())
}
