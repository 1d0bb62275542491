//! PostgreSQL, and what speaks as it does: any number of servers on one database.
//!
//! Reading is the same as everywhere. Who writes holds the cells of what it writes ([`cell_writer`]); what others have
//! written shows in the cells' rows, which every server looks at a few times a second ([`other_servers`]); work in the
//! background belongs to whoever holds its lease ([`lease`]), diagnoses to whoever has claimed them ([`claim`]).

mod bounded;
pub(in crate::store) mod cell_rows;
mod cell_writer;
pub mod claim;
pub(in crate::store) mod hosts;
mod lease;
pub(in crate::store) mod names;
pub(in crate::store) mod open;
mod other_servers;

pub(super) use self::bounded::PgReaders;
pub use self::cell_rows::{ChangeTopic, RemoteChanges};
pub(super) use self::cell_writer::CellWriter;
pub use self::lease::LeasedTask;
pub use self::other_servers::ChangeFeed;
pub(super) use self::other_servers::OtherServers;
