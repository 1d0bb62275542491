//! `void` and `revise`: what was stored counts no more, or another stands in its place. Nothing is deleted.

use bytes::Bytes;
use serde_json::{Value, json};

use super::client::{ClientError, Connection, JSON, Sent, Service};
use super::import::{source, withdrawn};
use super::prelude::*;
use super::{block_on, faults};
use crate::core::message::{Message, list, sent};
use crate::wire::campaign_csv::parse_csv_as_sent;
use crate::wire::json::said_of;
use crate::wire::problem::ProblemBody;

/// Say that a stored record, campaign or bench result counts no more; it stays, with who said so and why
#[derive(Debug, clap::Args)]
pub struct Void {
    /// Its identifier, as the answer gave it
    id: String,

    #[command(flatten)]
    remark: ReasonArgs,

    #[command(flatten)]
    connection: Connection,
}

/// Put the right record or campaign in the place of a wrong one; both stay, with who said so and why
///
/// Without --of it takes the place of what is stored for the same IMU and time.
#[derive(Debug, clap::Args)]
pub struct Revise {
    /// The right one alone: a record or a campaign in JSON, CSV or xlsx
    file: PathBuf,

    /// Identifier of the wrong one
    #[arg(long, value_name = "ID")]
    of: Option<String>,

    #[command(flatten)]
    remark: ReasonArgs,

    #[command(flatten)]
    connection: Connection,
}

/// Who says so, and why.
#[derive(Debug, PartialEq, clap::Args)]
pub(super) struct ReasonArgs {
    /// Who says so
    #[arg(long)]
    pub author: String,

    /// Why
    #[arg(long)]
    pub reason: String,
}

impl Void {
    pub fn run(self) -> anyhow::Result<()> {
        block_on(async {
            let service = self.connection.service()?;
            let order = json!({ "author": self.remark.author, "reason": self.remark.reason }).to_string();
            let post = |kind: &str| post(&service, format!("/v1/{kind}/{}/void", self.id), order.clone());
            // A campaign is a record too; a bench result is none.
            let sent = match post("records").await {
                Err(trouble) if trouble.is_not_found() => match post("bench-results").await {
                    Err(trouble) if trouble.is_not_found() => {
                        bail!("404: {}", said(message!("terminal_nothing_to_void", id = sent(&self.id))))
                    }
                    other => other?,
                },
                other => other?,
            };
            let standing = match sent {
                Sent::Stored(answer) | Sent::Known(answer) => answer,
                Sent::Refused(problem) => bail!(refused(&problem)),
            };
            let id = standing["id"].as_str().unwrap_or(&self.id).to_owned();
            document::print(&said(message!("terminal_is_voided", id)))
        })
    }
}

impl Revise {
    pub fn run(self) -> anyhow::Result<()> {
        let name = document::name(&self.file);
        let bytes = document::read(&self.file)?;
        document::note_open_end(&self.file, &bytes);
        block_on(async {
            let service = self.connection.service()?;
            match replace(&service, &bytes, self.of.as_deref(), &self.remark).await? {
                Ok(done) => document::print(&format!("{name}: {done}")),
                Err(refused) => bail!("{name}: {refused}"),
            }
        })
    }
}

/// Puts a document in the place of another, or of what is stored for its IMU and time; in words what was done, or why
/// it was refused.
///
/// # Errors
/// The service is away, or does not let this caller.
pub(super) async fn replace(
    service: &Service,
    bytes: &[u8],
    of: Option<&str>,
    who: &ReasonArgs,
) -> Result<Result<String, String>, ClientError> {
    let (kind, member, new) = match read(bytes) {
        Ok(read) => read,
        Err(why) => return Ok(Err(why)),
    };
    if of.is_none()
        && let Some(nothing) = absent(service, &new).await
    {
        return Ok(Err(said(nothing)));
    }
    let id = match of {
        Some(id) => id.to_owned(),
        None => match post(service, format!("/v1/{kind}"), new.to_string()).await? {
            Sent::Refused(ProblemBody { status: 409, existing: Some(id), .. }) => id,
            Sent::Refused(problem) => return Ok(Err(refused(&problem))),
            Sent::Known(answer) => {
                // The answer to an earlier try may have been lost, where it still counts.
                let of = match withdrawn(&answer) {
                    None => revised_by(service, (kind, &id_of(&answer)), who).await?,
                    Some(_) => None,
                };
                return Ok(of.map(|of| in_place_of(&of, &answer)).ok_or_else(|| known(&answer)));
            }
            Sent::Stored(answer) => return Ok(Ok(said(message!("terminal_was_new", id = id_of(&answer))))),
        },
    };
    let order = json!({ "author": who.author, "reason": who.reason, member: new }).to_string();
    Ok(match post(service, format!("/v1/{kind}/{id}/revise"), order).await? {
        Sent::Refused(problem) => Err(refused(&problem)),
        Sent::Stored(answer) | Sent::Known(answer) => Ok(in_place_of(&id, &answer)),
    })
}

/// That nothing is stored for a document's IMU and time, with what is stored at the nearest times: one of the two times
/// is mistyped, and a document of its own would leave the wrong one standing.
async fn absent(service: &Service, new: &Value) -> Option<Message> {
    const NEAREST: usize = 3;
    let imu = new["imu"].as_str()?;
    let time = new["measured_at"].as_str().or_else(|| new["calibrated_at"].as_str())?;
    if !stored(service, &[("imu", imu), ("from", time), ("to", time)]).await?.is_empty() {
        return None;
    }
    let at = time::parse(time).ok()?;
    let others = stored(service, &[("imu", imu)]).await?;
    let mut others: Vec<(f64, String)> = others
        .iter()
        .filter_map(|other| {
            let (id, then) = (other["id"].as_str()?, other["calibrated_at"].as_str()?);
            Some((time::parse(then).ok()?.days_since(at).abs(), format!("{then} ({id})")))
        })
        .collect();
    others.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (imu, time) = (sent(imu), sent(time));
    Some(match others.is_empty() {
        true => message!("terminal_revise_none", imu, time),
        false => {
            let nearest = list(others.into_iter().take(NEAREST).map(|(_, other)| other));
            message!("terminal_revise_absent", imu, time, nearest)
        }
    })
}

/// Stored records and campaigns; none where the service does not say.
async fn stored(service: &Service, query: &[(&str, &str)]) -> Option<Vec<Value>> {
    let (mut all, mut next) = (Vec::new(), None);
    loop {
        let query =
            query.iter().copied().chain([("limit", "1000")]).chain(next.as_deref().map(|next| ("cursor", next)));
        let query = url::form_urlencoded::Serializer::new(String::new()).extend_pairs(query).finish();
        let answer = service.ask(&format!("/v1/records?{query}")).await.ok()?;
        all.extend(answer["records"].as_array()?.iter().cloned());
        next = answer["next"].as_str().map(str::to_owned);
        if next.is_none() {
            return Some(all);
        }
    }
}

fn in_place_of(old: &str, answer: &Value) -> String {
    said(message!("terminal_stands", old = old.to_owned(), new = id_of(answer)))
}

fn id_of(answer: &Value) -> String {
    answer["id"].as_str().unwrap_or("?").to_owned()
}

/// That a document is stored already; where it counts no more, why, and how it counts again.
fn known(answer: &Value) -> String {
    let id = id_of(answer);
    let Some(standing) = withdrawn(answer) else { return said(message!("terminal_is_stored", id)) };
    let stored = said(message!("terminal_is_withdrawn", id, standing));
    match answer["revised_by"]["record"].as_str() {
        Some(other) => format!("{stored}; {}", said(message!("terminal_put_back", id = other.to_owned()))),
        None => stored,
    }
}

/// What a stored item stands in the place of, where the same person said so in the same words.
async fn revised_by(
    service: &Service,
    (kind, id): (&str, &str),
    who: &ReasonArgs,
) -> Result<Option<String>, ClientError> {
    let stored = service.ask(&format!("/v1/{kind}/{id}")).await?;
    let revises = &stored["revises"];
    let same = revises["author"] == who.author && revises["reason"] == who.reason;
    Ok(revises["record"].as_str().filter(|_| same).map(str::to_owned))
}

/// Where a document belongs, what a revision calls it, and the document as JSON; or why there is none.
fn read(bytes: &[u8]) -> Result<(&'static str, &'static str, Value), String> {
    let document = source::single(bytes.to_vec()).map_err(|unreadable| unreadable.why)?;
    let new = if document.content_type == JSON {
        serde_json::from_slice(&document.body)
            .map_err(|error| said(message!("value_not_json", why = said_of(&error))))?
    } else {
        let (campaign, _) = parse_csv_as_sent(&document.body).map_err(|found| faults::in_words(&found))?;
        json!(campaign)
    };
    match document.route {
        "/v1/campaigns" => Ok(("campaigns", "campaign", new)),
        "/v1/records" => Ok(("records", "record", new)),
        _ => Err(word("terminal_bench_revise").to_owned()),
    }
}

async fn post(service: &Service, route: String, body: String) -> Result<Sent, ClientError> {
    service.post(&route, JSON, Bytes::from(body)).await
}

fn refused(problem: &ProblemBody) -> String {
    faults::of_problem(problem).unwrap_or_else(|| problem.detail.clone())
}
