//! A real Prometheus, for tests.

use gyrowatch::system;
use tempfile::TempDir;

use crate::prelude::*;

/// Prometheus with the rules that ship, looking every second; it ends with the test.
pub struct Prometheus {
    _child: Running,
    address: String,
    _dir: TempDir,
}

impl Prometheus {
    pub fn watching(server: &Server) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let rules = root().join("config/prometheus/rules.yml");
        let config = format!(
            "global: {{ scrape_interval: 1s, evaluation_interval: 1s }}\nrule_files: [{}]\nscrape_configs:\n  \
             - job_name: gyrowatch\n    static_configs: [{{ targets: [\"{}\"] }}]\n",
            rules.display(),
            server.address()
        );
        std::fs::write(dir.path().join("prometheus.yml"), config).unwrap();
        let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
        let child = Command::new("prometheus")
            .current_dir(dir.path())
            .args(["--config.file=prometheus.yml", "--storage.tsdb.path=data"])
            .arg(format!("--web.listen-address={address}"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        Self { _child: Running(child), address, _dir: dir }
    }

    /// What it answers; null before it does.
    async fn answers(&self, path: &str) -> Value {
        let client = system::http_client(Duration::from_secs(5), Duration::from_secs(5)).build().unwrap();
        match client.get(format!("http://{}/api/v1/{path}", self.address)).send().await {
            Ok(answer) => serde_json::from_str(&answer.text().await.unwrap()).unwrap_or_default(),
            Err(_) => Value::Null,
        }
    }

    /// The series that a query comes to now; what stands in its way.
    pub async fn series(&self, query: &str) -> Result<Vec<Value>, String> {
        let encoded = url::form_urlencoded::byte_serialize(query.as_bytes()).collect::<String>();
        let answer = self.answers(&format!("query?query={encoded}")).await;
        let series = answer["data"]["result"].as_array().filter(|_| answer["status"] == "success");
        series.cloned().ok_or_else(|| answer.to_string())
    }

    /// The names of the alerts that fire.
    pub async fn firing(&self) -> Vec<String> {
        let alerts = self.answers("alerts").await["data"]["alerts"].as_array().cloned().unwrap_or_default();
        let firing = alerts.iter().filter(|alert| alert["state"] == "firing");
        firing.map(|alert| alert["labels"]["alertname"].as_str().unwrap().to_owned()).collect()
    }

    pub async fn scrapes(&self) -> bool {
        self.series("gyrowatch_items_total").await.is_ok_and(|series| !series.is_empty())
    }
}
