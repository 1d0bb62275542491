//! Tells systemd how far the service is (`Type=notify`, sd_notify(3)); without systemd nobody is told.

use std::ffi::OsStr;
use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};

/// Connections are accepted.
pub(super) const READY: &str = "READY=1";
/// Told to stop: requests in flight are finished.
pub(super) const STOPPING: &str = "STOPPING=1";

/// Tells the supervisor that `NOTIFY_SOCKET` names, if it names one.
pub(super) fn tell(state: &str) {
    if let Some(socket) = std::env::var_os("NOTIFY_SOCKET").filter(|name| !name.is_empty())
        && let Err(error) = send(&socket, state)
    {
        tracing::warn!(%error, ?socket, "the supervisor could not be told");
    }
}

/// A name that begins with `@` is one of Linux' abstract sockets.
fn send(socket: &OsStr, state: &str) -> io::Result<()> {
    let address = match socket.as_bytes().strip_prefix(b"@") {
        Some(name) => SocketAddr::from_abstract_name(name)?,
        None => SocketAddr::from_pathname(socket)?,
    };
    UnixDatagram::unbound()?.send_to_addr(state.as_bytes(), &address)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sockets_in_files_and_abstract_ones_are_told() {
        let dir = tempfile::TempDir::new().unwrap();
        let (file, name) = (dir.path().join("notify"), format!("gyrowatch-notify-{}", std::process::id()));
        let in_file = UnixDatagram::bind(&file).unwrap();
        let without_file = UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(&name).unwrap()).unwrap();
        for (socket, told) in [(file.into_os_string(), in_file), (format!("@{name}").into(), without_file)] {
            send(&socket, READY).unwrap();
            let mut text = [0; 16];
            let length = told.recv(&mut text).unwrap();
            assert_eq!(&text[..length], READY.as_bytes());
        }
    }
}
