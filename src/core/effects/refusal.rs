//! Why a campaign cannot be held against the model.

/// Why a campaign cannot be diagnosed at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    #[error(
        "{dwells} dwells leave nothing over the {parameters} parameters of the model: nothing can be held against it"
    )]
    TooFewDwells { dwells: usize, parameters: usize },
    #[error("the output of {0} is the same in every dwell")]
    NoOutput(&'static str),
    #[error("the geometry names no axes for {0}")]
    NoAxes(&'static str),
    #[error("the model holds no terms")]
    NoTerms,
}
