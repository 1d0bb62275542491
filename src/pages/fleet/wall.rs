//! The fleet by IMU: a card an IMU, a row a slot, a cell a coefficient, each with its load; for a screen on a wall.

use super::filters::Filters;
use crate::pages::prelude::*;
use crate::pages::{bullet, status as badges};
use crate::pipeline::GyroStatus;

/// IMUs on one page.
const IMUS: usize = 60;

pub(super) async fn build(pages: &Pages, viewer: &Viewer, filters: &Filters) -> Result<Page, Problem> {
    let t = viewer.text();
    let (filter, fleet) = (filters.filter()?, &pages.pipeline.queries.fleet);
    let counted = fleet.page(&filter, 0, 1).await?;
    let wall = fleet.wall(&filter, filters.page, IMUS).await?;
    let body = html! {
        h1 { (t.fleet) " · " (t.by_imu) }
        (filters.tiles(t, &counted))
        (filters.form(t, &counted))
        @if wall.imus.is_empty() { p.lead { (t.none_found) } }
        @else {
            p.note { (wall.found) " " (t.imus_worst_first) }
            div.wall { @for (imu, gyros) in &wall.imus { (card(t, imu, gyros)) } }
            (filters.pager(t, wall.number, wall.last))
        }
    };
    Ok(Page { title: t.fleet.into(), section: Section::Fleet, body })
}

fn card(t: &Text, imu: &str, gyros: &[GyroStatus]) -> Markup {
    let worst = gyros.iter().filter_map(|gyro| gyro.status).max();
    html! {
        article.card.(worst.map_or("none", Status::name)) {
            h2 { a.id href={ "/imus/" (encoded(imu)) } { (imu) } " " (badges::badge(t, worst)) }
            table {
                thead { tr { th { (t.slot) } @for name in DRIFTS { th.n { (symbol(name)) (t.percent_sign) } } } }
                tbody { @for gyro in gyros { (line(t, gyro)) } }
            }
        }
    }
}

fn line(t: &Text, gyro: &GyroStatus) -> Markup {
    let slot = gyro.newest.map_or("", |newest| newest.slot.name());
    html! {
        tr {
            th scope="row" { a href={ "/gyros/" (encoded(&gyro.serial)) } title=(gyro.serial) { (slot) } }
            @for (load, status) in gyro.projection.load.iter().zip(gyro.drift) {
                td.n.(status.name()) title=(t.status(status)) {
                    span.hidden { (t.status(status)) " " }
                    (or_dash(load.map(bullet::rounded)))
                    @if status > Status::NotEnoughData { (badges::mark(status)) }
                }
            }
        }
    }
}
