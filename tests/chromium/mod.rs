//! A real headless Chromium, driven over the WebDriver protocol (w3.org/TR/webdriver2) through its chromedriver.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Child;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use crate::prelude::*;
use crate::support::client;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gyrowatch::system;

/// WebDriver's name for a reference to an element.
const ELEMENT: &str = "element-6066-11e4-a52e-4f735466cecf";
/// How long a page may take until something is there.
const PATIENCE: Duration = Duration::from_secs(90);

pub struct Browser {
    driver: Child,
    session: String,
    http: reqwest::Client,
    /// Address of the service; nothing else may be asked.
    base: String,
    /// What a person has done since [`Browser::begin_job`].
    clicks: AtomicUsize,
    fields: AtomicUsize,
}

/// Whether the programs are there. Where they are required, their absence is a failure.
pub fn is_installed() -> bool {
    let there = |name: &str| Command::new(name).arg("--version").stdout(Stdio::null()).status().is_ok();
    let installed = there("chromium") && there("chromedriver");
    if !installed {
        let required = std::env::var("GYROWATCH_TEST_PROGRAMS").is_ok_and(|value| value == "required");
        assert!(!required, "chromium and chromedriver are required");
        eprintln!("passed over: chromium and chromedriver are not installed");
    }
    installed
}

/// axe-core's source, where `npm ci --prefix tests/chromium` has put it. Where it is required, its absence is a
/// failure.
pub fn axe() -> Option<String> {
    let file = root().join("tests/chromium/node_modules/axe-core/axe.min.js");
    let source = std::fs::read_to_string(file).ok();
    if source.is_none() {
        let required = std::env::var("GYROWATCH_TEST_AXE").is_ok_and(|value| value == "required");
        assert!(!required, "axe-core is required: npm ci --prefix tests/chromium");
        eprintln!("passed over: axe-core is not installed (npm ci --prefix tests/chromium)");
    }
    source
}

impl Browser {
    /// Opens a browser of its own whose downloads go to `downloads`.
    pub async fn open(base: &str, downloads: &Path) -> Self {
        system::install_crypto();
        let mut driver =
            Command::new("chromedriver").arg("--port=0").stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut lines = BufReader::new(driver.stdout.take().unwrap()).lines();
        let port = lines
            .find_map(|line| {
                line.unwrap().strip_suffix('.')?.split_once("successfully on port ")?.1.parse::<u16>().ok()
            })
            .expect("chromedriver names its port");
        // Whatever else it says has to go somewhere.
        std::thread::spawn(move || lines.for_each(drop));
        let http = client();
        let arguments = [
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--hide-scrollbars",
            "--disable-background-networking",
            "--disable-component-update",
            "--no-first-run",
            "--lang=en-GB",
        ];
        let options = json!({"args": arguments, "perfLoggingPrefs": {"enableNetwork": true},
            "prefs": {"download.default_directory": downloads, "intl.accept_languages": "en-GB,en"}});
        let capabilities = json!({"capabilities": {"alwaysMatch": {"browserName": "chrome", "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}}});
        let endpoint = format!("http://127.0.0.1:{port}/session");
        let opened = ask(&http, &endpoint, &capabilities).await;
        let session = format!("{endpoint}/{}", opened["sessionId"].as_str().expect("a session"));
        let browser = Self {
            driver,
            session,
            http,
            base: base.to_owned(),
            clicks: AtomicUsize::new(0),
            fields: AtomicUsize::new(0),
        };
        browser.cdp("Browser.setDownloadBehavior", json!({"behavior": "allow", "downloadPath": downloads})).await;
        browser
    }

    async fn post(&self, command: &str, body: &Value) -> Value {
        ask(&self.http, &format!("{}/{command}", self.session), body).await
    }

    /// A command of Chromium's own protocol.
    pub async fn cdp(&self, command: &str, parameters: Value) -> Value {
        self.post("goog/cdp/execute", &json!({"cmd": command, "params": parameters})).await
    }

    pub async fn goto(&self, path: &str) {
        self.post("url", &json!({"url": format!("{}{path}", self.base)})).await;
    }

    /// The value of a JavaScript expression.
    pub async fn eval(&self, expression: &str) -> Value {
        self.post("execute/sync", &json!({"script": format!("return {expression}"), "args": []})).await
    }

    /// Waits until the expression is true.
    pub async fn wait(&self, expression: &str) {
        let started = Instant::now();
        while self.eval(&format!("Boolean({expression})")).await != Value::Bool(true) {
            assert!(started.elapsed() < PATIENCE, "never came true: {expression}\n{}", self.text().await);
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }

    /// As soon as the page has it: a form's answer may still be on its way.
    async fn element(&self, selector: &str) -> String {
        self.wait(&format!("document.querySelector({selector:?})")).await;
        let found = self.post("element", &json!({"using": "css selector", "value": selector})).await;
        found[ELEMENT].as_str().unwrap_or_else(|| panic!("nothing fits {selector}: {found}")).to_owned()
    }

    /// From the start page on.
    pub async fn begin_job(&self) {
        self.goto("/").await;
        self.clicks.store(0, Relaxed);
        self.fields.store(0, Relaxed);
    }

    /// Clicks, and fields that were filled in.
    pub fn took(&self) -> (usize, usize) {
        (self.clicks.load(Relaxed), self.fields.load(Relaxed))
    }

    pub async fn click(&self, selector: &str) {
        self.clicks.fetch_add(1, Relaxed);
        let element = self.element(selector).await;
        self.post(&format!("element/{element}/click"), &json!({})).await;
    }

    /// Types into a field; of a file field, chooses the file.
    pub async fn type_into(&self, selector: &str, text: &str) {
        self.fields.fetch_add(1, Relaxed);
        let element = self.element(selector).await;
        self.post(&format!("element/{element}/value"), &json!({"text": text})).await;
    }

    /// Presses a key by its name in DOM events.
    pub async fn press(&self, key: &str) {
        let code = match key {
            "ArrowLeft" => '\u{e012}',
            "ArrowRight" => '\u{e014}',
            "ArrowDown" => '\u{e015}',
            "Tab" => '\u{e004}',
            "Enter" => '\u{e007}',
            _ => panic!("{key} is not among the keys that tests press"),
        };
        let press = |kind: &str| json!({"type": kind, "value": code});
        let steps = json!([press("keyDown"), press("keyUp")]);
        self.post("actions", &json!({"actions": [{"type": "key", "id": "keys", "actions": steps}]})).await;
    }

    /// Presses at the first point, moves to the second, lets go; in pixels of the view.
    pub async fn drag(&self, from: (f64, f64), to: (f64, f64)) {
        let go = |(x, y): (f64, f64)| json!({"type": "pointerMove", "duration": 100, "x": x as i64, "y": y as i64});
        let half = ((from.0 + to.0) / 2.0, (from.1 + to.1) / 2.0);
        let press = |kind: &str| json!({"type": kind, "button": 0});
        let steps = json!([go(from), press("pointerDown"), go(half), go(to), press("pointerUp")]);
        self.post("actions", &json!({"actions": [{"type": "pointer", "id": "mouse", "actions": steps}]})).await;
    }

    /// From the next page on every page can be judged by axe-core.
    pub async fn learn_axe(&self, source: &str) {
        self.cdp("Page.enable", json!({})).await;
        self.cdp("Page.addScriptToEvaluateOnNewDocument", json!({"source": source})).await;
    }

    /// What axe-core calls serious or critical on this page.
    pub async fn grave_faults(&self) -> Value {
        self.eval(
            "axe.run(document, {resultTypes: ['violations']}).then((found) => found.violations \
            .filter((fault) => fault.impact === 'serious' || fault.impact === 'critical') \
            .map((fault) => `${fault.impact} ${fault.id}: ${fault.help}: ${fault.nodes.map((node) => node.html.slice(0, 120)).join(' | ')}`))",
        )
        .await
    }

    /// What a person reads.
    pub async fn text(&self) -> String {
        self.eval("document.body.innerText").await.as_str().unwrap_or_default().to_owned()
    }

    pub async fn sees(&self, text: &str) {
        let shown = self.text().await;
        assert!(shown.contains(text), "{text} is not on the page:\n{shown}");
    }

    /// The view's size in pixels, and whether the system is dark.
    pub async fn look(&self, width: u32, height: u32, dark: bool) {
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600});
        self.cdp("Emulation.setDeviceMetricsOverride", size).await;
        let scheme = if dark { "dark" } else { "light" };
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.cdp("Emulation.setEmulatedMedia", json!({"features": features})).await;
    }

    /// The whole page as a picture.
    pub async fn picture(&self, file: &Path) {
        let taken = self.cdp("Page.captureScreenshot", json!({"captureBeyondViewport": true})).await;
        let bytes = BASE64_STANDARD.decode(taken["data"].as_str().expect("a picture")).unwrap();
        std::fs::write(file, bytes).unwrap();
    }

    /// The page as its style sheet has it for paper.
    pub async fn on_paper(&self) {
        self.cdp("Emulation.setEmulatedMedia", json!({"media": "print"})).await;
    }

    /// The page printed.
    pub async fn pdf(&self) -> Vec<u8> {
        let printed = self.cdp("Page.printToPDF", json!({"printBackground": true, "preferCSSPageSize": true})).await;
        BASE64_STANDARD.decode(printed["data"].as_str().expect("a document")).unwrap()
    }

    /// Fails where the console has complaints, or a request went anywhere but to the service.
    pub async fn has_behaved(&self) {
        let console = self.post("se/log", &json!({"type": "browser"})).await;
        let complaints: Vec<&Value> =
            console.as_array().into_iter().flatten().filter(|entry| entry["level"] == "SEVERE").collect();
        assert!(complaints.is_empty(), "the console complains: {complaints:#?}");
        let events = self.post("se/log", &json!({"type": "performance"})).await;
        let mut asked = 0;
        for event in events.as_array().into_iter().flatten() {
            let message: Value = serde_json::from_str(event["message"].as_str().unwrap()).unwrap();
            if message["message"]["method"] != "Network.requestWillBeSent" {
                continue;
            }
            let url = message["message"]["params"]["request"]["url"].as_str().unwrap();
            let own =
                url.starts_with(&format!("{}/", self.base)) || url.starts_with("data:") || url.starts_with("blob:");
            assert!(own, "a request left the server: {url}");
            asked += 1;
        }
        assert!(asked > 0, "requests are seen");
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Ending the session closes the browser; the driver alone would leave it running.
        let (_, address) = self.session.split_once("://").expect("an address");
        let (host, path) = address.split_once('/').expect("a path");
        if let Ok(mut stream) = TcpStream::connect(host) {
            let end = format!("DELETE /{path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n");
            // The driver keeps the connection open whatever it is told: its status line is the sign that the browser
            // is gone.
            let _gone_too = stream.set_read_timeout(Some(Duration::from_secs(10)));
            let _gone_too = stream.write_all(end.as_bytes());
            let _answered = stream.read(&mut [0; 64]);
        }
        let _already_gone = self.driver.kill();
        let _reaped = self.driver.wait();
    }
}

async fn ask(http: &reqwest::Client, url: &str, body: &Value) -> Value {
    let answer = http.post(url).json(body).send().await.unwrap_or_else(|e| panic!("{url}: {e}"));
    let mut answer: Value = answer.json().await.unwrap();
    assert!(answer["value"]["error"].is_null(), "{url}: {}", answer["value"]);
    answer["value"].take()
}
