//! Behind a real nginx: as it comes, with the headers that it is told to send, and under a prefix.

use crate::command::beside;
use crate::nginx::Nginx;
use crate::prelude::*;
use crate::support::{FORM, data_path, required};

/// Who asks through nginx: curl, which speaks HTTP/2 and follows nothing.
struct Client {
    base: String,
    token: String,
    further: Vec<String>,
}

struct Seen {
    status: u16,
    version: String,
    /// One line each, as they came.
    headers: String,
    body: String,
}

impl Seen {
    fn header(&self, name: &str) -> Option<&str> {
        let found = self.headers.lines().filter_map(|line| line.split_once(':'));
        found.filter(|(of, _)| of.eq_ignore_ascii_case(name)).map(|(_, value)| value.trim()).next()
    }

    fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|why| panic!("{why}: {}", self.body))
    }
}

impl Client {
    fn of(base: String) -> Self {
        Self { base, token: String::new(), further: Vec::new() }
    }

    fn with(&self, token: &str, further: &[&str]) -> Self {
        let further = further.iter().map(|argument| (*argument).to_owned()).collect();
        Self { base: self.base.clone(), token: token.to_owned(), further }
    }

    fn get(&self, path: &str) -> Seen {
        self.call(path, &[])
    }

    fn post(&self, path: &str, media_type: &str, body: &str) -> Seen {
        self.call(path, &["-H", &format!("content-type: {media_type}"), "--data-binary", body])
    }

    fn call(&self, path: &str, arguments: &[&str]) -> Seen {
        let certificate = data_path("tls/one.crt");
        let mut command = Command::new("curl");
        command.args(["-sS", "-i", "-g", "--max-time", "120", "-H", "Expect:", "-w", "\nversion %{http_version}"]);
        command.arg("--cacert").arg(certificate).args(arguments).args(&self.further);
        if !self.token.is_empty() {
            command.args(["-H", &format!("authorization: Bearer {}", self.token)]);
        }
        let output = command.arg(format!("{}{path}", self.base)).output().unwrap();
        assert!(output.status.success(), "{path}: {}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        let (text, version) = text.rsplit_once("\nversion ").unwrap();
        let (headers, body) = text.split_once("\r\n\r\n").unwrap();
        let status = headers.split(' ').nth(1).unwrap().trim().parse().unwrap();
        Seen { status, version: version.to_owned(), headers: headers.to_owned(), body: body.to_owned() }
    }
}

/// Made beside the service, as its documentation says.
fn admin_token(server: &Server) -> String {
    let output = beside(server.dir()).args(["token", "create", "first", "--role", "admin"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

const TRUSTING: (&str, &str) = ("GYROWATCH_SERVER__TRUSTED_PROXIES", "127.0.0.1/32");
/// What nginx is to be told, as docs/how-to/nginx.md has it.
const TELLING: &str = "proxy_set_header Host $http_host;
proxy_set_header X-Forwarded-For $proxy_add_x_forwarded_for;
proxy_set_header X-Forwarded-Proto $scheme;
proxy_set_header X-Forwarded-Host $http_host;
proxy_set_header Forwarded \"\";
client_max_body_size 0;
";

fn can_be_asked() -> bool {
    required("nginx") && required("curl")
}

#[tokio::test]
async fn through_nginx_as_it_comes_nobody_is_an_administrator() {
    if !can_be_asked() {
        return;
    }
    let server = Server::start_with(&[("GYROWATCH_ACCESS__OPEN", "")]).await;
    let nginx = Nginx::start(&format!("location / {{ proxy_pass http://{}; }}", server.address()), false);
    let client = Client::of(format!("http://{}", nginx.address()));
    let token = r#"{"name":"mine","role":"admin"}"#;
    let hook = r#"{"kind":"cloudevents","url":"http://127.0.0.1:9/"}"#;
    for (path, body) in [("/v1/tokens", token), ("/v1/hooks", hook)] {
        let refused = client.post(path, "application/json", body);
        assert_eq!(refused.status, 401, "{path}: {}", refused.body);
    }
    for path in ["/v1/tokens", "/v1/audit", "/hooks/new"] {
        assert_eq!(client.get(path).status, 401, "{path}");
    }
    let log = server.log();
    assert!(log.contains("WARN") && log.contains("Behind a proxy make a token first"), "{log}");
    let (_, secret) = log.split_once("setup_secret=\"").unwrap();
    let setup = client.with(secret.split('"').next().unwrap(), &[]);
    assert_eq!(setup.post("/v1/tokens", "application/json", token).status, 201);
    assert_eq!(setup.post("/v1/tokens", "application/json", token).status, 401);
    assert_eq!(client.get("/v1/gyros").status, 401);
}

#[tokio::test]
async fn clients_are_told_apart_by_the_word_of_a_proxy_that_is_trusted() {
    if !can_be_asked() {
        return;
    }
    let server = Server::start_with(&[TRUSTING]).await;
    let admin = admin_token(&server);
    let location = format!("location / {{ proxy_pass http://{};\n{TELLING} }}", server.address());
    let nginx = Nginx::start(&location, true);
    let client = Client::of(format!("https://{}", nginx.address()));
    // Who stands before nginx is a trusted proxy too: this machine. So the address before its own is the client's.
    let from = |address: &str| format!("x-forwarded-for: {address}");
    let guess = |address: &str, guess: usize| {
        client.with(&format!("gyw_{}_{guess:064x}", &admin[4..17]), &["-H", &from(address)]).get("/v1/gyros").status
    };
    for k in 0..10 {
        assert_eq!(guess("192.0.2.7", k), 401, "guess {k}");
    }
    assert_eq!(guess("192.0.2.7", 10), 429);
    assert_eq!(guess("192.0.2.8", 10), 401, "others are not locked out");
    assert_eq!(guess("203.0.113.1, 192.0.2.7", 10), 429, "what a client writes before its address changes nothing");
    assert!(server.log().contains("source=192.0.2.7"), "{}", server.log());

    let form = format!("token={admin}&back=%2Fstations");
    let origin = format!("origin: https://{}", nginx.address());
    let browser = client.with("", &["-H", &origin, "-H", &from("192.0.2.9"), "-A", "Firefox"]);
    let entered = browser.post("/sign-in", FORM, &form);
    assert_eq!((entered.status, entered.header("location")), (303, Some("/stations")), "{}", entered.body);
    assert!(
        entered.header("set-cookie").unwrap().ends_with("; Path=/; Max-Age=43200; HttpOnly; SameSite=Strict; Secure")
    );
    assert_eq!(entered.header("cache-control"), Some("no-store"));
    assert_eq!(entered.header("strict-transport-security"), Some("max-age=31536000"));
    let line = client.with(&admin, &[]).get("/v1/audit?action=sign%20in").json()["lines"][0].clone();
    assert_eq!((&line["source"], &line["agent"]), (&json!("192.0.2.9"), &json!("Firefox")), "{line}");
    // The same word of whoever is not trusted is no word.
    let direct = Server::start().await;
    let told = [("x-forwarded-for", "192.0.2.7"), ("x-forwarded-proto", "https"), ("authorization", "Bearer x")];
    let answer = direct.call("GET", "/v1/gyros", &told, "").await;
    assert!(answer.status == 401 && !answer.headers.contains_key("strict-transport-security"));
    assert!(direct.log().contains("source=127.0.0.1"), "{}", direct.log());
}

#[tokio::test]
async fn over_http_2_with_and_without_the_clients_host_everything_arrives_whole() {
    if !can_be_asked() {
        return;
    }
    let server = Server::start_with(&[TRUSTING]).await;
    let admin = admin_token(&server);
    let dir = tempfile::tempdir().unwrap();
    let gzip = "gzip on; gzip_proxied any; gzip_types *; gzip_min_length 1;";
    let telling_no_host = TELLING.lines().filter(|line| !line.contains("Host")).collect::<Vec<_>>().join("\n");
    for (k, telling) in [TELLING, &telling_no_host].into_iter().enumerate() {
        let location = format!("{gzip} location / {{ proxy_pass http://{};\n{telling}\n}}", server.address());
        let nginx = Nginx::start(&location, true);
        let client = Client::of(format!("https://{}", nginx.address())).with(&admin, &["--http2", "--compressed"]);
        // Some 13 MB, where nginx takes 1 MB unless it is told otherwise.
        let note = "n".repeat(4000);
        let lines = (0..2400).map(|minute| {
            let mut record = paper_record(k, minute);
            record["note"] = note.clone().into();
            record.to_string() + "\n"
        });
        let file = dir.path().join("lines");
        std::fs::write(&file, lines.collect::<String>()).unwrap();
        let imported = client.post("/v1/import", "application/x-ndjson", &format!("@{}", file.display()));
        assert_eq!((imported.status, imported.version.as_str()), (200, "2"), "{}", imported.body);
        assert_eq!(imported.body.matches("\"status\":201").count(), 2400);
        let page = client.get("/");
        assert_eq!((page.status, page.header("content-encoding")), (200, Some("gzip")));
        assert!(page.body.contains("</html>"));
        let trend = format!("/v1/gyros/G-{k}-0/trend?coefficient=D_I&limit=10000");
        let bearer = format!("Bearer {admin}");
        let direct = server.call("GET", &trend, &[("authorization", &bearer)], "").await;
        assert_eq!(client.get(&trend).json(), direct.json());
        // A browser that says only where its page comes from.
        let origin = format!("origin: https://{}", nginx.address());
        let form = format!("token={admin}");
        let old = Client::of(client.base.clone()).with("", &["-H", &origin]);
        let entered = old.post("/sign-in", FORM, &form).status;
        assert_eq!(entered, if k == 0 { 303 } else { 403 }, "nginx must pass the name on that the browser uses");
        let same = ["-H", origin.as_str(), "-H", "sec-fetch-site: same-origin"];
        let new = Client::of(client.base.clone()).with("", &same);
        assert_eq!(new.post("/sign-in", FORM, &form).status, 303);
    }
}

/// What an attribute of a page's elements leads to.
fn led_to(page: &str, attribute: &str) -> Vec<String> {
    let opening = format!(" {attribute}=\"");
    page.split(&opening).skip(1).map(|rest| rest.split('"').next().unwrap().replace("&amp;", "&")).collect()
}

/// A fleet with an alert, a campaign, a bench result, a hook with deliveries, a silence: every page has something to
/// show.
async fn furnish(server: &Server) {
    server.stores_half_a_year().await;
    assert_eq!(server.post("/v1/campaigns", "application/json", data("practice/campaign-00.json")).await.status, 201);
    let hook = server.post_json("/v1/hooks", &json!({ "kind": "cloudevents", "url": "http://127.0.0.1:9/" })).await;
    let test = format!("/v1/hooks/{}/test", hook.json()["id"].as_str().unwrap());
    assert_eq!(server.post(&test, "application/json", "").await.status, 202);
    let silence =
        json!({ "matchers": { "imu": "IMU-99" }, "until": "2099-01-01T00:00:00Z", "by": "Li", "reason": "quiet" });
    assert_eq!(server.post_json("/v1/silences", &silence).await.status, 201);
}

#[tokio::test]
async fn under_a_prefix_every_page_and_every_answer_leads_under_it() {
    if !can_be_asked() {
        return;
    }
    let mut server = Server::start().await;
    furnish(&server).await;
    let admin = admin_token(&server);
    assert!(server.terminate().0.success());
    let server =
        Server::start_under(&[], server.into_dir(), &[("GYROWATCH_SERVER__BASE_PATH", "/gyrowatch"), TRUSTING]);
    // nginx passes the prefix on, or cuts it off; whatever is not under it is not there.
    for rest in ["", "/"] {
        let location = format!("location /gyrowatch/ {{ proxy_pass http://{}{rest};\n{TELLING} }}", server.address());
        let nginx = Nginx::start(&location, true);
        let root = Client::of(format!("https://{}", nginx.address()));
        assert_eq!(root.get("/").status, 404);
        let under = Client::of(format!("{}/gyrowatch", root.base));
        let browser = |cookie: &str| root.with("", &["-H", cookie, "-H", "accept: text/html", "--compressed"]);

        let sent_on = browser("a: b").get("/gyrowatch/stations?x=1");
        let to_sign_in = "/gyrowatch/sign-in?back=%2Fstations%3Fx%3D1";
        assert_eq!((sent_on.status, sent_on.header("location")), (303, Some(to_sign_in)));
        let form = format!("token={admin}&back=%2Fstations%3Fx%3D1");
        let entered = root.post("/gyrowatch/sign-in", FORM, &form);
        assert_eq!((entered.status, entered.header("location")), (303, Some("/gyrowatch/stations?x=1")));
        let cookie = entered.header("set-cookie").unwrap();
        assert!(cookie.contains("; Path=/gyrowatch;") && cookie.ends_with("; Secure"), "{cookie}");
        let cookie = format!("cookie: {}", cookie.split(';').next().unwrap());

        let (mut open, mut seen, mut forms) = (vec!["/gyrowatch/".to_owned()], BTreeSet::new(), BTreeSet::new());
        while let Some(path) = open.pop() {
            if !seen.insert(path.split('#').next().unwrap().to_owned()) {
                continue;
            }
            let answer = browser(&cookie).get(&path);
            // A form in which nothing was chosen is answered 400.
            assert!(matches!(answer.status, 200 | 202 | 303 | 400 | 422), "{path}: {}", answer.status);
            open.extend(answer.header("location").map(|at| {
                assert!(at.starts_with("/gyrowatch/"), "{path}: Location {at}");
                at.to_owned()
            }));
            let is_page = answer.header("content-type").is_some_and(|of| of.starts_with("text/html"));
            if !is_page {
                continue;
            }
            for attribute in ["href", "src", "action", "formaction"] {
                for at in led_to(&answer.body, attribute) {
                    if at.starts_with('#') || at == "data:," {
                        continue;
                    }
                    // A query alone is one of this page.
                    let here = path.split(['?', '#']).next().unwrap();
                    let at = if at.starts_with('?') { format!("{here}{at}") } else { at };
                    assert!(at.starts_with("/gyrowatch/"), "{path}: {attribute} {at}");
                    if attribute == "action" {
                        forms.insert(at.split('?').next().unwrap().to_owned());
                    } else if !at.contains("/preference?") || path.ends_with("/stations") {
                        // Every page has them; of one page is enough.
                        open.push(at);
                    }
                }
            }
        }
        println!("{} addresses followed, {} forms sent", seen.len(), forms.len());
        assert!(seen.len() > 60 && forms.len() > 8, "{seen:?} {forms:?}");
        for part in [
            "gyros/LFG-0101",
            "records/",
            "campaigns/",
            "hooks/",
            "assets/style",
            "docs/hooks",
            "alerts/",
            "preference",
        ] {
            assert!(seen.iter().any(|path| path.starts_with(&format!("/gyrowatch/{part}"))), "{part}: {seen:?}");
        }
        // Forms lead somewhere, and what they do leads back under the prefix.
        let own = ["-H", cookie.as_str(), "-H", "sec-fetch-site: same-origin"];
        for at in &forms {
            let done = root.with("", &own).post(at, FORM, "");
            // These only ask.
            let asks = ["/alerts", "/compare", "/fleet", "/find", "/reports", "/"].iter().any(|end| at.ends_with(end));
            assert!(!matches!(done.status, 404 | 405) || asks, "{at}: {}", done.status);
            assert!(done.header("location").is_none_or(|to| to.starts_with("/gyrowatch/")), "{at}");
        }
        let api = under.with(&admin, &[]);
        let served = api.get("/openapi.json").json()["servers"].clone();
        assert_eq!(served, json!([{ "url": "/gyrowatch" }]));
        let known = api.post("/v1/records", "application/json", &data("paper.json"));
        assert!(known.header("location").unwrap().starts_with("/gyrowatch/v1/records/"), "{}", known.headers);
        let trail = api.get("/v1/audit?limit=1");
        assert!(trail.header("link").unwrap().starts_with("</gyrowatch/v1/audit?limit=1&cursor="), "{}", trail.headers);
    }
    // Whoever watches the service itself needs no prefix.
    assert_eq!(server.get("/healthz").await.status, 200);
}
