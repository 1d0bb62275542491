//! `--model`: terms of model (6) by name, or a model file.

use crate::cli::common::wrong;
use crate::cli::prelude::*;
use crate::core::augmented::AugmentedModel;
use crate::core::model::Terms;
use crate::wire::campaign::terms_from_names;
use crate::wire::model;

/// What `--model` says.
#[derive(Debug, Clone)]
pub enum Choice {
    Terms(Terms),
    File(PathBuf),
}

/// `bias,scale` and the like are terms, anything else is the path of a model file.
pub fn choice(argument: &str) -> Result<Choice, String> {
    match terms(argument) {
        Ok(terms) => Ok(Choice::Terms(terms)),
        Err(_) if Path::new(argument).is_file() => Ok(Choice::File(argument.into())),
        Err(faults) => Err(wrong(message!("terminal_no_model_file", faults))),
    }
}

/// Terms of model (6) with commas between them.
pub fn terms(argument: &str) -> Result<Terms, String> {
    let names: Vec<&str> = argument.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
    terms_from_names(&names)
        .map_err(|faults| faults.0.into_iter().map(|fault| wrong(fault.message)).collect::<Vec<_>>().join("; "))
}

/// The model that was chosen; without a choice the plain one: each campaign's own terms.
pub fn chosen(choice: Option<&Choice>) -> anyhow::Result<AugmentedModel> {
    match choice {
        None => Ok(AugmentedModel::default()),
        Some(Choice::Terms(terms)) => Ok(AugmentedModel { terms: Some(*terms), ..AugmentedModel::default() }),
        Some(Choice::File(path)) => file(path),
    }
}

pub fn file(path: &Path) -> anyhow::Result<AugmentedModel> {
    model::parse(&document::read(path)?).with_context(|| document::name(path))
}

/// Refuses to replace a file that holds something else than a model.
pub fn may_be_replaced(path: &Path) -> anyhow::Result<()> {
    let is_file = std::fs::metadata(path).is_ok_and(|there| there.is_file() && there.len() > 0);
    if is_file && file(path).is_err() {
        bail!(said(message!("terminal_holds_no_model", file = path.display().to_string())));
    }
    Ok(())
}
