//! A real nginx in front of the service, on a free port, in a directory of its own.

use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::{data_path, free_port, is_root};

pub struct Nginx {
    child: Child,
    port: u16,
    dir: tempfile::TempDir,
}

impl Nginx {
    /// With `server`, lines of a server's block; `encrypted` over TLS and HTTP/2.
    pub fn start(server: &str, encrypted: bool) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let port = free_port();
        let (certificate, key) = (data_path("tls/one.crt"), data_path("tls/one.key"));
        let tls = format!("ssl_certificate {};\nssl_certificate_key {};", certificate.display(), key.display());
        let (options, tls) = if encrypted { (" ssl http2", tls.as_str()) } else { ("", "") };
        let user = if is_root() { "user root;" } else { "" };
        let temporary = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"];
        let temporary: String = temporary.iter().map(|of| format!("{of}_temp_path {of};\n")).collect();
        let text = format!(
            "daemon off;\n{user}\npid nginx.pid;\nerror_log error.log;\nevents {{}}\nhttp {{\naccess_log off;\n{temporary}\
             server {{\nlisten 127.0.0.1:{port}{options};\n{tls}\n{server}\n}}\n}}\n"
        );
        std::fs::write(dir.path().join("nginx.conf"), text).unwrap();
        let mut command = Command::new("nginx");
        command.arg("-p").arg(dir.path()).args(["-c", "nginx.conf", "-e", "error.log"]);
        let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let nginx = Self { child, port, dir };
        let patience = Instant::now() + Duration::from_secs(10);
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            assert!(Instant::now() < patience, "{}", nginx.log());
            std::thread::sleep(Duration::from_millis(20));
        }
        nginx
    }

    /// `127.0.0.1:port`.
    pub fn address(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    pub fn log(&self) -> String {
        std::fs::read_to_string(self.dir.path().join("error.log")).unwrap_or_default()
    }
}

impl Drop for Nginx {
    fn drop(&mut self) {
        // SIGTERM: killed, it would leave its workers behind.
        let _gone = Command::new("kill").args(["-TERM", &self.child.id().to_string()]).status();
        let _reaped = self.child.wait();
        if std::thread::panicking() {
            eprintln!("--- log of nginx\n{}", self.log());
        }
    }
}
