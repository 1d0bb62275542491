//! `diagnose --gyro SERIAL`: why the coefficients of a gyro changed, as a running service answers it.

use super::diagnose_all::FleetArgs;
use crate::cli::common::block_on;
use crate::cli::prelude::*;
use crate::wire::history::{CoefficientBody, HistoryDiagnosisBody};
use crate::wire::text::encoded;

pub fn run(serial: &str, fleet: &FleetArgs, format: Format) -> anyhow::Result<()> {
    let service = fleet.service()?;
    let route = format!("/v1/gyros/{}/diagnosis", encoded(serial));
    let answer: HistoryDiagnosisBody = block_on(async { service.get(&route).await })?;
    format.show(&answer, || tables(&answer))
}

fn tables(answer: &HistoryDiagnosisBody) -> String {
    let mut parts =
        vec![said(message!("terminal_peers", serial = answer.serial.clone(), peers = answer.peers.to_string()))];
    for coefficient in &answer.coefficients {
        parts.push(format!("{}: {}", coefficient.coefficient, coefficient.said.join("\n  ")));
        if !coefficient.candidates.is_empty() {
            parts.push(candidates(coefficient));
        }
    }
    parts.join("\n\n")
}

fn candidates(coefficient: &CoefficientBody) -> String {
    let mut rows = table_of("terminal_not_named_head", 0..0);
    for candidate in &coefficient.candidates {
        rows.add_row([candidate.cause.as_ref(), &candidate.detail, &candidate.reason]);
    }
    rows.to_string()
}
