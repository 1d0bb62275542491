//! The gap of a campaign against an earlier calibration of its IMU, split into parameters, structure and noise: a
//! section of the page of its diagnosis.

use super::figure::short;
use super::prelude::*;
use crate::core::kind::{Kind, RecordEntry};
use crate::pipeline::StoredCampaign;
use crate::wire::diagnosis::DiagnosisBody;
use crate::wire::split::{MovedBody, PartsBody, SplitBody};

/// Calibrations of the IMU that are offered.
const OFFERED: u32 = 60;

/// `?reference=ID`; the newest calibration before the campaign where left out.
#[derive(Debug, Default, Deserialize)]
pub(super) struct ReferenceQuery {
    reference: Option<String>,
}

/// What the campaign can be held against, and what came of the one that was chosen.
pub(super) struct ReferenceComparison {
    /// Newest first.
    offered: Vec<RecordEntry>,
    chosen: Option<Id>,
    split: Option<Result<SplitBody, Message>>,
}

impl ReferenceComparison {
    /// # Errors
    /// 404, where what is asked for is not stored; not where it is no reference for this campaign: the page says so.
    pub async fn of(
        pages: &Pages,
        stored: &StoredCampaign,
        diagnosis: &DiagnosisBody,
        asked: &ReferenceQuery,
    ) -> Result<Self, Problem> {
        let mut offered = pages.pipeline.queries.records.of_imu(stored.item.imu, OFFERED).await?;
        offered.retain(|head| head.id != stored.item.id);
        let newest_before = offered.iter().find(|head| head.calibrated_at < stored.item.calibrated_at);
        let chosen = match asked.reference.as_deref().filter(|text| !text.is_empty()) {
            Some(text) => Some(problem::id(text, Problem::no_such_reference)?),
            None => newest_before.map(|head| head.id),
        };
        let split = match chosen {
            Some(id) => {
                let split = pages.pipeline.diagnoses.split(stored.item.id, diagnosis, id).await?;
                Some(split.ok_or_else(|| Problem::no_such_reference(id))?.map_err(|why| why.message()))
            }
            None => None,
        };
        Ok(Self { offered, chosen, split })
    }

    pub fn section(&self, t: &Text) -> Markup {
        html! {
            @if !self.offered.is_empty() {
                section {
                    h2 { (t.against) }
                    (self.choice(t))
                    @match &self.split {
                        Some(Ok(split)) => (parts(t, split)),
                        Some(Err(why)) => p { (t.words(why)) },
                        None => p { (t.none_before) },
                    }
                }
            }
        }
    }

    fn choice(&self, t: &Text) -> Markup {
        let kind = |head: &RecordEntry| if head.kind == Kind::Campaign { t.kind_campaign } else { t.kind_record };
        html! {
            form method="get" {
                label { (t.reference) " "
                    select name="reference" {
                        @for head in &self.offered {
                            option value=(head.id) selected[self.chosen == Some(head.id)] {
                                (instant(head.calibrated_at)) " · " (kind(head))
                            }
                        }
                    }
                }
                " " button { (t.hold_against) }
            }
        }
    }
}

pub(super) fn parts(t: &Text, split: &SplitBody) -> Markup {
    let gyros = split.gyros.iter().map(|gyro| (gyro.slot.as_str(), &gyro.parts));
    let rows = [(t.all_gyros, &split.all)].into_iter().chain(gyros);
    html! {
        p.note { span translate="no" { (split.station) } " · " (written(&split.measured_at)) " · " (t.against_note) }
        (wide_table("", html! {
            th { (t.serial) } th.n { (t.whole_gap) } th.n { (t.part_parameters) } th.n { (t.part_structure) }
            th.n { (t.part_noise) } th.n { (t.p_parameters) }
        }, html! { @for (slot, p) in rows { (part_row(slot, p)) } }))
        (wide_table("", html! {
            th { (t.serial) } th { (t.coefficient) } th.n { (t.reference) }
            th.n { (t.now) } th.n { (t.shift) } th.n { "1 σ" } th { (t.unit_word) }
        }, html! { @for moved in &split.moved { (moved_row(t, moved)) } }))
        @if !split.notes.is_empty() { ul { @for note in &split.notes { li { (note) } } } }
    }
}

fn part_row(slot: &str, p: &PartsBody) -> Markup {
    let numbers = [p.whole_deg_per_h, p.parameters_deg_per_h, p.structure_deg_per_h, p.noise_deg_per_h, p.p_value];
    html! { tr { th scope="row" { (slot) } @for number in numbers { td.n { (short(number)) } } } }
}

/// Every figure to the place of its uncertainty.
fn moved_row(t: &Text, moved: &MovedBody) -> Markup {
    let places = figure::places_beside(moved.sd, 6);
    html! {
        tr {
            td { (moved.slot) } td { (symbol(&moved.coefficient)) }
            td.n { (format!("{:.places$}", moved.reference)) } td.n { (format!("{:.places$}", moved.now)) }
            td.n { (format!("{:+.places$}", moved.shift)) }
            td.n { (or_dash(moved.sd.map(|sd| format!("{sd:.places$}")))) }
            td { (t.unit_of(&moved.unit)) }
        }
    }
}
