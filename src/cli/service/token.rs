//! `token`: who may use the service. Works on the database itself, so that the first token can be made before the
//! service runs and nobody is locked out.

use clap::Subcommand;

use super::healthcheck;
use super::settings::ConfigArgs;
use crate::cli::common::{block_on, instant, one_of};
use crate::cli::prelude::*;
use crate::config::Config;
use crate::core::access::{Role, Token};
use crate::core::fault::Faults;
use crate::core::message::sent;
use crate::core::time::UtcMicros;
use crate::pipeline::{NewToken, Refused, create_beside, revoke_beside};
use crate::store::{StoreError, TokenDatabase};
use crate::system::Clock;
use crate::wire::text;

/// Make, list and revoke access tokens
#[derive(Debug, Args)]
pub struct TokenArgs {
    #[command(subcommand)]
    order: TokenCommand,
    #[command(flatten)]
    config: ConfigArgs,
}

#[derive(Debug, Subcommand)]
enum TokenCommand {
    /// Make a token and print it, this once
    Create {
        /// Who or what will use it
        name: String,
        /// What it may do: viewer (read), station (send and read), engineer (acknowledge, mark events, adopt models),
        /// admin (all)
        #[arg(long, value_parser = role)]
        role: Role,
        /// The only station that it may send for; with the role station alone
        #[arg(long)]
        station: Option<String>,
        /// When it ends, RFC 3339
        #[arg(long, value_name = "TIME", conflicts_with = "days", value_parser = instant)]
        expires_at: Option<UtcMicros>,
        /// After how many days it ends
        #[arg(long, value_name = "DAYS", value_parser = clap::value_parser!(u32).range(1..=MOST_DAYS))]
        days: Option<u32>,
    },
    /// List every token there ever was
    List,
    /// Revoke a token for good
    Revoke {
        /// Identifier, as `list` shows it
        id: String,
    },
}

/// For as long a token may be made, days.
const MOST_DAYS: i64 = 1_000_000;

fn role(name: &str) -> Result<Role, String> {
    one_of(Role::from_name(name), Role::ALL.map(Role::name))
}

impl TokenArgs {
    pub fn run(self) -> anyhow::Result<()> {
        let Config { database, server, .. } = self.config.load()?;
        let (order, options) = (self.order, database.options());
        let is_new = options.file().is_ok_and(|file| matches!(file.try_exists(), Ok(false)));
        if is_new && !matches!(order, TokenCommand::Create { .. }) {
            bail!(said(message!("terminal_no_database", database = options.shown())));
        }
        let is_unnamed = database.url == Config::defaults().database.url;
        let work = async {
            if is_new && is_unnamed && healthcheck::is_running(&server).await {
                let (listen, database) = (server.listen.to_string(), options.shown());
                bail!(said(message!("terminal_other_database", listen, database)));
            }
            if is_new {
                eprintln!("{}", said(message!("terminal_new_database", database = options.shown())));
            }
            let mut beside = TokenDatabase::open(&options).await?;
            order.carry_out(&mut beside, Clock::System.now()).await
        };
        block_on(work).map_err(|error| match is_of_the_database(&error) {
            true => error.context(said(message!("terminal_database", url = database.options().shown()))),
            false => error,
        })
    }
}

/// Whether the database failed, and not what was asked of it.
fn is_of_the_database(error: &anyhow::Error) -> bool {
    error.is::<StoreError>() || matches!(error.downcast_ref(), Some(Refused::Storage(_)))
}

impl TokenCommand {
    async fn carry_out(self, database: &mut TokenDatabase, now: UtcMicros) -> anyhow::Result<()> {
        match self {
            Self::Create { name, role, station, expires_at, days } => {
                let after = days.map(|days| UtcMicros(now.0 + i64::from(days) * UtcMicros::DAY));
                let new = checked(name, role, station, expires_at.or(after), now)?;
                let secret = create_beside(database, &new, now).await?;
                let made = message!(
                    "terminal_token_made",
                    id = secret.id.to_string(),
                    name = new.name.to_string(),
                    role = role.name()
                );
                eprintln!("{}", said(made));
                document::print(&secret.reveal())
            }
            Self::List => document::print(&table(&database.tokens().await?, now)),
            Self::Revoke { id } => {
                let Ok(id) = id.parse() else { bail!(said(message!("terminal_no_token_id", id = sent(&id)))) };
                let now_revoked = revoke_beside(database, id, now).await?;
                let id = id.to_string();
                document::print(&said(match now_revoked {
                    true => message!("terminal_token_revoked", id),
                    false => message!("terminal_token_revoked_before", id),
                }))
            }
        }
    }
}

fn checked(
    name: String,
    role: Role,
    station: Option<String>,
    expires_at: Option<UtcMicros>,
    now: UtcMicros,
) -> Result<NewToken, Faults> {
    let mut faults = Faults::default();
    let name = text::required_short("NAME", name, &mut faults);
    NewToken::check_station(role, station.as_deref(), "--station", &mut faults);
    let station = station.map(|station| text::name("--station", &station, &mut faults).to_string());
    if expires_at.is_some_and(|at| at <= now) {
        faults.push("--expires-at", message!("not_in_future"));
    }
    faults.or(NewToken { name, role, station, expires_at })
}

fn table(tokens: &[Token], now: UtcMicros) -> String {
    let mut table = document::table_of("terminal_tokens_head", 0..0);
    for token in tokens {
        let state = match (token.revoked_at, token.expires_at) {
            (Some(at), _) => said(message!("terminal_revoked", at = time::format(at))),
            (None, Some(at)) if at <= now => said(message!("terminal_expired", at = time::format(at))),
            (None, Some(at)) => said(message!("terminal_until", at = time::format(at))),
            (None, None) => word("terminal_valid").to_owned(),
        };
        let station = token.station.clone().unwrap_or_else(|| word("terminal_any").to_owned());
        let made = time::format(token.created_at);
        table.add_row([token.id.to_string(), token.name.clone(), token.role.name().into(), station, made, state]);
    }
    table.to_string()
}

#[cfg(test)]
mod tests {
    use clap::{Args as _, Command};

    use super::*;

    fn faults(role: Role, station: Option<&str>, expires_at: Option<UtcMicros>) -> Vec<(String, String)> {
        let made = checked("x".into(), role, station.map(str::to_owned), expires_at, UtcMicros(10));
        let faults = made.err().map_or_else(Vec::new, |faults| faults.0);
        faults.into_iter().map(|fault| (fault.pointer, fault.message.code.into_owned())).collect()
    }

    #[test]
    fn a_station_is_taken_only_where_it_limits() {
        for role in Role::ALL {
            let refused = [("--station".to_owned(), "station_of_role".to_owned())];
            let expected: &[_] = if role == Role::Station { &[] } else { &refused };
            assert_eq!(faults(role, Some("ST-2"), None), expected, "{}", role.name());
            assert_eq!(faults(role, None, None), [], "{}", role.name());
        }
    }

    #[test]
    fn a_token_that_would_not_last_is_refused_by_the_name_of_its_option() {
        let past = faults(Role::Admin, None, Some(UtcMicros(9)));
        assert_eq!(past, [("--expires-at".to_owned(), "not_in_future".to_owned())]);
        for (days, is_taken) in [("0", false), ("1", true), ("4294967295", false)] {
            let command = TokenArgs::augment_args(Command::new("token"));
            let read = command.try_get_matches_from(["token", "create", "x", "--role", "admin", "--days", days]);
            let said = read.err().map(|error| error.to_string());
            assert_eq!(said.is_none(), is_taken, "{said:?}");
            assert!(said.is_none_or(|said| said.contains("--days")));
        }
    }
}
