//! Who may do what, seen from outside: tokens and roles on every route, signing in with a browser, guesses, exposure.

use crate::command::{beside, on_database};
use crate::lab;
use crate::prelude::*;
use crate::support::{Answer, FORM};

/// Routes that need no token.
const OPEN: [&str; 7] = [
    "GET /healthz",
    "GET /readyz",
    "GET /sign-in",
    "POST /sign-in",
    "POST /sign-out",
    "GET /preference",
    "GET /assets/{name}",
];
const ENGINEERS: [&str; 62] = [
    "POST /import/replace",
    "PATCH /v1/gyros",
    "PATCH /v1/gyros/{serial}",
    "GET /gyros/{serial}/attributes",
    "POST /gyros/{serial}/attributes",
    "POST /v1/stations/{name}/suspect",
    "POST /v1/stations/{name}/trust",
    "GET /stations/{name}/suspect",
    "POST /stations/{name}/suspect",
    "GET /stations/{name}/trust",
    "POST /stations/{name}/trust",
    "GET /alerts/bulk",
    "POST /alerts/bulk",
    "GET /setup",
    "POST /v1/diagnoses",
    "DELETE /v1/diagnoses/{id}",
    "POST /diagnoses",
    "POST /diagnoses/{id}/cancel",
    "POST /v1/bench-results/{id}/void",
    "POST /v1/campaigns/{id}/revise",
    "POST /v1/campaigns/{id}/void",
    "POST /v1/records/{id}/confirm",
    "POST /v1/records/{id}/revise",
    "POST /v1/records/{id}/void",
    "GET /alerts/{id}/{deed}",
    "GET /campaigns/{id}/adopt",
    "GET /bench-results/{id}/void",
    "GET /campaigns/{id}/void",
    "GET /gyros/{serial}/events/new",
    "GET /hooks",
    "GET /hooks/{id}",
    "GET /imus/{imu}/model/undo",
    "GET /records/{id}/confirm",
    "GET /records/{id}/void",
    "POST /alerts/{id}/{deed}",
    "POST /bench-results/{id}/void",
    "POST /campaigns/{id}/adopt",
    "POST /campaigns/{id}/void",
    "POST /gyros/{serial}/events/new",
    "POST /hooks/{id}/deliveries/{delivery}/redeliver",
    "POST /hooks/{id}/redeliver",
    "POST /hooks/{id}/test",
    "POST /imus/{imu}/model/undo",
    "POST /records/{id}/confirm",
    "POST /records/{id}/void",
    "GET /v1/deliveries/{id}",
    "GET /v1/hooks",
    "GET /v1/hooks/{id}",
    "GET /v1/hooks/{id}/deliveries",
    "POST /v1/alerts/{id}/acknowledge",
    "POST /v1/alerts/{id}/silence",
    "POST /v1/alerts/{id}/unacknowledge",
    "POST /v1/silences",
    "POST /v1/silences/{id}/end",
    "GET /silences/new",
    "POST /silences/new",
    "GET /silences/{id}/end",
    "POST /silences/{id}/end",
    "POST /v1/deliveries/{id}/redeliver",
    "POST /v1/gyros/{serial}/baseline",
    "POST /v1/gyros/{serial}/events",
    "POST /v1/hooks/{id}/test",
];
/// Of what reads nothing but needs no engineer.
const STATIONS: [&str; 7] = [
    "POST /v1/records",
    "POST /v1/campaigns",
    "POST /v1/bench-results",
    "POST /v1/import",
    "GET /import",
    "POST /import/preview",
    "POST /import/store",
];
const MODELLERS: [&str; 3] = ["POST /v1/imus/{imu}/model", "POST /v1/hypotheses", "DELETE /v1/hypotheses/{id}"];
const ADMINS: [&str; 12] = [
    "GET /hooks/new",
    "GET /hooks/{id}/delete",
    "POST /hooks/new",
    "POST /hooks/{id}/delete",
    "POST /hooks/{id}/enabled",
    "DELETE /v1/hooks/{id}",
    "DELETE /v1/tokens/{id}",
    "GET /v1/audit",
    "GET /v1/tokens",
    "PATCH /v1/hooks/{id}",
    "POST /v1/hooks",
    "POST /v1/tokens",
];

/// Makes a token over HTTP as `maker` (nobody, for the first), with further members of the body.
async fn token(server: &Server, maker: &str, role: &str, further: Value) -> (String, String) {
    let mut body = json!({ "name": format!("the {role}"), "role": role });
    body.as_object_mut().unwrap().extend(further.as_object().unwrap().clone());
    let made = call(server, "POST", "/v1/tokens", maker, &body.to_string()).await.created();
    (made["token"].as_str().unwrap().to_owned(), made["id"].as_str().unwrap().to_owned())
}

/// As the holder of a token; nobody's where it is empty.
async fn call(server: &Server, method: &str, path: &str, token: &str, body: &str) -> Answer {
    let bearer = if token.is_empty() { String::new() } else { format!("Bearer {token}") };
    let content_type = if body.is_empty() { "" } else { "application/json" };
    server.call(method, path, &[("authorization", &bearer), ("content-type", content_type)], body.to_owned()).await
}

/// Every method of every route, as the documentation has them; a test of the unit's holds it against the router.
fn routes() -> BTreeSet<String> {
    let rows = include_str!("../docs/routes.md").lines().filter_map(|line| line.strip_prefix("| "));
    let routes: BTreeSet<String> = rows
        .filter_map(|row| Some((row.split_once(" | `")?.0, row.split('`').nth(1)?)))
        .map(|(method, path)| format!("{method} {path}"))
        .collect();
    assert!(routes.len() > 45 && routes.contains("GET /stations") && routes.contains("POST /sign-in"), "{routes:?}");
    routes
}

#[tokio::test]
async fn every_route_asks_for_a_token_that_is_valid_and_has_the_role() {
    let server = Server::start_with(&[("GYROWATCH_ACCESS__FAILURES_PER_MINUTE", "1000000")]).await;
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    let (engineer, _) = token(&server, &admin, "engineer", json!({})).await;
    let (station, _) = token(&server, &admin, "station", json!({})).await;
    let (viewer, _) = token(&server, &admin, "viewer", json!({})).await;
    let soon = jiff::Timestamp::from_microsecond(gyrowatch::system::Clock::System.now().0 + 700_000).unwrap();
    let (expired, _) = token(&server, &admin, "admin", json!({ "expires_at": soon.to_string() })).await;
    let (revoked, id) = token(&server, &admin, "admin", json!({})).await;
    assert_eq!(call(&server, "DELETE", &format!("/v1/tokens/{id}"), &admin, "").await.status, 204);
    tokio::time::sleep(Duration::from_millis(800)).await;
    let wrong = format!("{}0", &admin[..admin.len() - 1]);
    let wrong = if wrong == admin { format!("{}1", &admin[..admin.len() - 1]) } else { wrong };

    let (mut no_viewer, mut no_station, mut no_engineer) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for route in routes() {
        let (method, path) = route.split_once(' ').unwrap();
        let path = path.replace(['{', '}'], "");
        let open = OPEN.contains(&route.as_str());
        for (what, token) in [
            ("no", ""),
            ("a wrong", &*wrong),
            ("an expired", &*expired),
            ("a revoked", &*revoked),
            ("garbage for a", "x"),
        ] {
            let answer = call(&server, method, &path, token, "").await;
            if open {
                assert!(!matches!(answer.status, 401 | 403) || path == "/sign-in", "{route}: {}", answer.status);
                continue;
            }
            assert_eq!(answer.status, 401, "{route} with {what} token");
            assert_eq!(answer.content_type, "application/problem+json", "{route} with {what} token");
            let challenge = answer.headers["www-authenticate"].to_str().unwrap();
            assert!(challenge.starts_with("Bearer"), "{route} with {what} token: {challenge}");
        }
        for (token, refused) in [(&viewer, &mut no_viewer), (&station, &mut no_station), (&engineer, &mut no_engineer)]
        {
            let answer = call(&server, method, &path, token, "").await;
            assert_ne!(answer.status, 401, "{route}");
            if answer.status == 403 {
                assert!(answer.headers["www-authenticate"].to_str().unwrap().contains("insufficient_scope"), "{route}");
                refused.insert(route.clone());
            }
        }
    }
    let owned = |routes: &[&str]| routes.iter().map(|route| (*route).to_owned()).collect::<BTreeSet<_>>();
    assert_eq!(no_engineer, owned(&ADMINS));
    assert_eq!(no_station, owned(&[&ADMINS[..], &ENGINEERS, &MODELLERS].concat()));
    assert_eq!(no_viewer, owned(&[&ADMINS[..], &ENGINEERS, &MODELLERS, &STATIONS].concat()));
    let changing = |route: &&String| !route.starts_with("GET ") && !OPEN.contains(&route.as_str());
    assert!(routes().iter().filter(changing).all(|route| no_viewer.contains(route)));
    assert_eq!(call(&server, "GET", "/metrics", &viewer, "").await.status, 200);
    // What nobody has said anything about, a method or a path, is refused or not there.
    assert_eq!(call(&server, "PUT", "/v1/gyros", &station, "").await.status, 405);
    assert_eq!(call(&server, "GET", "/v1/nothing", "", "").await.status, 404);
}

#[tokio::test]
async fn without_tokens_this_machine_reads_posts_and_acknowledges_and_makes_no_token_and_no_hook() {
    let server = Server::start_with(&[("GYROWATCH_ACCESS__OPEN", "")]).await;
    let mut record = paper_record(1, 0);
    for month in 1..=6 {
        record["calibrated_at"] = format!("2026-0{month}-01T08:00:00Z").into();
        record["gyros"][0]["g_pulse_per_s_g0"][0] = (2.4210 + if month > 4 { 0.05 } else { 0.0 }).into();
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    }
    let alert = server.get("/v1/alerts").await.json()["alerts"][0]["id"].as_str().unwrap().to_owned();
    let word = json!({ "by": "Li", "reason": "seen" });
    assert_eq!(server.post_json(&format!("/v1/alerts/{alert}/acknowledge"), &word).await.status, 200);
    for route in ADMINS {
        let (method, path) = route.split_once(' ').unwrap();
        let answer = call(&server, method, &path.replace(['{', '}'], ""), "", "{}").await;
        assert_eq!((answer.status, answer.content_type.as_str()), (401, "application/problem+json"), "{route}");
        assert!(answer.text().contains("gyrowatch token create"), "{}", answer.text());
    }
    let log = server.log();
    assert!(log.contains("WARN") && log.contains("Behind a proxy make a token first"), "{log}");
    let setup = setup_secret(&log);
    let wrong = format!("{}{}", &setup[..setup.len() - 1], if setup.ends_with('0') { '1' } else { '0' });
    let first = json!({ "name": "first", "role": "admin" }).to_string();
    assert_eq!(call(&server, "POST", "/v1/tokens", &wrong, &first).await.status, 401);
    let hook = json!({ "kind": "cloudevents", "url": "http://127.0.0.1:9/" }).to_string();
    assert_eq!(call(&server, "POST", "/v1/hooks", &setup, &hook).await.status, 201, "as any administrator");
    // Of two at once one is made.
    let (one, other) = tokio::join!(
        call(&server, "POST", "/v1/tokens", &setup, &first),
        call(&server, "POST", "/v1/tokens", &setup, &first)
    );
    let mut statuses = [one.status, other.status];
    statuses.sort_unstable();
    assert_eq!(statuses, [201, 401]);
    let made = if one.status == 201 { one } else { other };
    assert_eq!(made.headers["cache-control"], "no-store");
    let admin = made.json()["token"].as_str().unwrap().to_owned();
    assert_eq!(call(&server, "POST", "/v1/tokens", &setup, &first).await.status, 401, "it is used up");
    for role in ["viewer", "engineer", "admin"] {
        let limited = json!({ "name": "a", "role": role, "station": "ST-2" }).to_string();
        let refused = call(&server, "POST", "/v1/tokens", &admin, &limited).await;
        assert_eq!(refused.status, 422, "{role}");
        assert_eq!(refused.json()["errors"][0]["code"], "station_of_role", "{role}");
    }
    assert_eq!(server.get("/v1/gyros").await.status, 401);
    let trail = call(&server, "GET", "/v1/audit?action=create%20token", &admin, "").await.json();
    assert_eq!(trail["lines"][0]["who"], "setup");
    assert!(
        !std::fs::read(server.dir().join("gyrowatch.db-wal"))
            .unwrap()
            .windows(64)
            .any(|w| w == &setup.as_bytes()[18..])
    );
}

/// The secret that the start shows where there is no token.
fn setup_secret(log: &str) -> String {
    let (_, from) = log.split_once("setup_secret=").unwrap_or_else(|| panic!("{log}"));
    from.trim_start_matches('"').chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect()
}

#[tokio::test]
async fn from_the_first_header_of_a_proxy_on_nobody_is_let_in_without_a_token() {
    for header in ["forwarded", "x-forwarded-for", "x-forwarded-proto", "x-real-ip", "via"] {
        let server = Server::start_with(&[("GYROWATCH_ACCESS__OPEN", "")]).await;
        assert_eq!(server.get("/v1/gyros").await.status, 200);
        let through = server.call("GET", "/v1/gyros", &[(header, "1.1 proxy")], "").await;
        assert_eq!((through.status, through.content_type.as_str()), (403, "application/problem+json"), "{header}");
        assert_eq!(server.get("/v1/gyros").await.status, 403, "the next may come through it too");
        assert_eq!(server.get("/healthz").await.status, 200);
        assert!(server.log().contains("a request came through a proxy"), "{}", server.log());
        let made =
            call(&server, "POST", "/v1/tokens", &setup_secret(&server.log()), r#"{"name":"a","role":"admin"}"#).await;
        assert_eq!(made.status, 201, "whoever has the secret of the log is let in");
    }
    for configured in ["GYROWATCH_SERVER__TRUSTED_PROXIES", "GYROWATCH_SERVER__BASE_PATH"] {
        let value = if configured.ends_with("PATH") { "/gyrowatch" } else { "10.0.0.0/8" };
        let server = Server::start_with(&[("GYROWATCH_ACCESS__OPEN", ""), (configured, value)]).await;
        assert_eq!(server.get("/v1/gyros").await.status, 403, "{configured}");
    }
}

#[tokio::test]
async fn until_the_first_token_an_open_service_may_be_asked_for_everything_and_then_nothing_without_one() {
    let server = Server::start().await;
    assert!(server.log().contains("access.open is set"), "{}", server.log());
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 201);
    let (admin, id) = token(&server, "", "admin", json!({})).await;
    assert_eq!(server.get("/v1/gyros").await.status, 401);
    assert_eq!(call(&server, "GET", "/v1/gyros", &admin, "").await.status, 200);
    assert_eq!(call(&server, "DELETE", &format!("/v1/tokens/{id}"), &admin, "").await.status, 204);
    assert_eq!(call(&server, "GET", "/v1/gyros", &admin, "").await.status, 401);
    assert_eq!(server.get("/v1/gyros").await.status, 401, "revoking the last token opens nothing");
    for path in ["/healthz", "/readyz"] {
        assert_eq!(server.get(path).await.status, 200, "{path}");
    }
}

/// DNS rebinding: a page of `evil.example`, whose name then leads to this machine, is to the browser a page of this
/// service.
#[tokio::test]
async fn without_a_token_nothing_is_answered_under_another_name_than_this_machines() {
    let server = Server::start().await;
    let record = data("paper.json");
    let port = server.address().rsplit_once(':').unwrap().1;
    let rebound = format!("evil.example:{port}");
    let origin = format!("http://{rebound}");
    let asks = async |host: &str, method: &str, path: &str, body: &str, token: &str| {
        let content_type = if body.is_empty() { "" } else { "application/json" };
        let origin = if method == "GET" { "" } else { origin.as_str() };
        let headers = [("host", host), ("origin", origin), ("content-type", content_type), ("authorization", token)];
        server.call(method, path, &headers, body.to_owned()).await
    };
    for (method, path, body) in [
        ("GET", "/", ""),
        ("GET", "/v1/gyros", ""),
        ("GET", "/sign-in", ""),
        ("POST", "/v1/records", record.as_str()),
        ("POST", "/v1/tokens", r#"{"name": "mine", "role": "admin"}"#),
    ] {
        let answer = asks(&rebound, method, path, body, "").await;
        assert_eq!((answer.status, answer.content_type.as_str()), (421, "application/problem+json"), "{method} {path}");
        assert_eq!(answer.json()["code"], "other_name");
    }
    for path in ["/healthz", "/readyz", "/metrics"] {
        assert_eq!(asks(&rebound, "GET", path, "", "").await.status, 200, "{path}");
    }
    let localhost = format!("localhost:{port}");
    for host in [localhost.as_str(), "127.0.0.1", "[::1]:80"] {
        assert_eq!(asks(host, "GET", "/v1/gyros", "", "").await.status, 200, "{host}");
    }
    // A token says who asks, under whatever name.
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    assert_eq!(asks(&rebound, "GET", "/v1/gyros", "", &format!("Bearer {admin}")).await.status, 200);
}

#[tokio::test]
async fn a_stations_token_sends_for_that_station_alone_on_every_way_in() {
    let server = Server::start().await;
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    let record = document("paper.json");
    let own = record["station"].as_str().unwrap();
    let (mine, _) = token(&server, &admin, "station", json!({ "station": own })).await;
    let (other, _) = token(&server, &admin, "station", json!({ "station": "elsewhere" })).await;
    let mut campaign = document("practice/campaign-00.json");
    campaign["station"] = own.into();
    let bench = json!({ "serial": "LFG-0101", "station": own, "measured_at": "2026-03-02T08:00:00Z", "method": "torque_feedback",
        "d_i_deg_per_h_g0": 1.0, "d_s_deg_per_h_g0": 2.0 });
    for (path, body) in [("/v1/records", &record), ("/v1/bench-results", &bench), ("/v1/campaigns", &campaign)] {
        let refused = call(&server, "POST", path, &other, &body.to_string()).await;
        assert_eq!(refused.status, 403, "{path}: {}", refused.text());
        assert!(refused.text().contains("elsewhere"), "{}", refused.text());
        let taken = call(&server, "POST", path, &mine, &body.to_string()).await;
        assert_eq!(taken.status, 201, "{path}: {}", taken.text());
    }
    let bearer = format!("Bearer {other}");
    let headers = [("authorization", bearer.as_str()), ("content-type", "application/x-ndjson")];
    let lines = format!("{record}\n{bench}\n");
    let answers = server.call("POST", "/v1/import", &headers, lines).await.text();
    assert_eq!(answers.lines().filter(|line| line.contains("\"status\":403")).count(), 2, "{answers}");
    let headers = [("authorization", bearer.as_str()), ("content-type", "text/plain")];
    let form = format!("text={}\r\n", record.to_string().replace("2026-", "2025-"));
    let page = server.call("POST", "/import/store", &headers, form).await.text();
    assert!(page.contains("the token is only for the station elsewhere"), "{page}");
    let form = format!("text={record}\r\n");
    let preview = server.call("POST", "/import/preview", &headers, form).await.text();
    assert!(
        preview.contains("the token is only for the station elsewhere") && preview.contains("0 can be stored"),
        "{preview}"
    );
}

/// The cookie that an answer sets, as name=value.
fn cookie(answer: &Answer) -> String {
    answer.headers["set-cookie"].to_str().unwrap().split(';').next().unwrap().to_owned()
}

async fn sign_in(server: &Server, token: &str) -> Answer {
    let form = format!("token={token}&back=%2Fstations");
    server.call("POST", "/sign-in", &[("content-type", FORM)], form).await
}

#[tokio::test]
async fn a_browser_signs_in_with_a_token_and_out_again() {
    let server = Server::start().await;
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    let (engineer, id) = token(&server, &admin, "engineer", json!({})).await;
    let sent_on = server.call("GET", "/gyros/A?x=1", &[("accept", "text/html")], "").await;
    assert_eq!(
        (sent_on.status, sent_on.headers["location"].to_str().unwrap()),
        (303, "/sign-in?back=%2Fgyros%2FA%3Fx%3D1")
    );
    assert!(server.get("/sign-in?back=%2Fstations").await.text().contains("type=\"password\""));

    let entered = sign_in(&server, &engineer).await;
    assert_eq!((entered.status, entered.headers["location"].to_str().unwrap()), (303, "/stations"));
    let set = entered.headers["set-cookie"].to_str().unwrap();
    for attribute in ["HttpOnly", "SameSite=Strict", "Path=/", "Max-Age=43200"] {
        assert!(set.contains(attribute), "{set}");
    }
    let cookie = cookie(&entered);
    let as_browser = async |path: &str| server.call("GET", path, &[("cookie", cookie.as_str())], "").await;
    let page = as_browser("/stations").await;
    assert!(page.status == 200 && page.text().contains("/sign-out"), "{}", page.text());
    assert_eq!(as_browser("/v1/audit").await.status, 403, "it may no more than its token");

    let form = format!("text={}\r\n", data("paper.json"));
    for (origin, fetch_site, status) in [
        ("", "", 403),
        ("https://evil.example", "", 403),
        ("", "cross-site", 403),
        ("", "same-site", 403),
        ("", "same-origin", 200),
    ] {
        let headers = [
            ("cookie", cookie.as_str()),
            ("content-type", "text/plain"),
            ("origin", origin),
            ("sec-fetch-site", fetch_site),
        ];
        let answer = server.call("POST", "/import/preview", &headers, form.clone()).await;
        assert_eq!(answer.status, status, "origin {origin:?}, {fetch_site:?}");
    }
    let own = format!("http://{}", server.address());
    let headers = [("cookie", cookie.as_str()), ("content-type", "text/plain"), ("origin", own.as_str())];
    assert_eq!(server.call("POST", "/import/preview", &headers, form).await.status, 200);

    let headers = [("cookie", cookie.as_str()), ("sec-fetch-site", "same-origin")];
    let left = server.call("POST", "/sign-out", &headers, "").await;
    assert!(left.status == 303 && left.headers["set-cookie"].to_str().unwrap().contains("Max-Age=0"));
    assert_eq!(as_browser("/stations").await.status, 401, "the old cookie is worth nothing");

    let again = self::cookie(&sign_in(&server, &engineer).await);
    assert_eq!(server.call("GET", "/stations", &[("cookie", &again)], "").await.status, 200);
    assert_eq!(call(&server, "DELETE", &format!("/v1/tokens/{id}"), &admin, "").await.status, 204);
    assert_eq!(server.call("GET", "/stations", &[("cookie", &again)], "").await.status, 401, "revoked with its token");

    let files = ["gyrowatch.db", "gyrowatch.db-wal", "log"].map(|name| std::fs::read(server.dir().join(name)).unwrap());
    for secret in [&admin, &engineer, &cookie["gyrowatch_session=".len()..].to_owned(), &again] {
        let digits = secret.rsplit('_').next().unwrap();
        let raw = hex::decode(digits).unwrap();
        for bytes in &files {
            let holds = |needle: &[u8]| bytes.windows(needle.len()).any(|window| window == needle);
            assert!(!holds(digits.as_bytes()) && !holds(&raw), "a secret lies on the disk");
        }
    }
}

#[tokio::test]
async fn a_browser_stays_signed_in_over_a_restart_until_its_hours_are_over() {
    let mut server = Server::start_with(&[("GYROWATCH_ACCESS__SESSION_HOURS", "0.001")]).await;
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    let cookie = cookie(&sign_in(&server, &admin).await);
    server.kill();
    server.restart();
    assert_eq!(server.call("GET", "/stations", &[("cookie", &cookie)], "").await.status, 200);
    tokio::time::sleep(Duration::from_millis(3700)).await;
    assert_eq!(server.call("GET", "/stations", &[("cookie", &cookie)], "").await.status, 401);
}

#[tokio::test]
async fn after_ten_wrong_tokens_a_minute_further_ones_are_put_off_and_right_ones_are_not() {
    let server = Server::start().await;
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    let id = &admin[4..17];
    for guess in 0..10 {
        let wrong = format!("gyw_{id}_{guess:064x}");
        let status = if guess % 2 == 0 {
            call(&server, "GET", "/v1/gyros", &wrong, "").await.status
        } else {
            sign_in(&server, &wrong).await.status
        };
        assert_eq!(status, 401, "guess {guess}");
    }
    for wrong in [format!("gyw_{id}_{:064x}", 10), "x".to_owned()] {
        let put_off = call(&server, "GET", "/v1/gyros", &wrong, "").await;
        assert_eq!((put_off.status, put_off.content_type.as_str()), (429, "application/problem+json"));
        let wait: u64 = put_off.headers["retry-after"].to_str().unwrap().parse().unwrap();
        assert!((1..=60).contains(&wait), "{wait}");
        let page = sign_in(&server, &wrong).await;
        assert!(page.status == 429 && page.headers.contains_key("retry-after"));
    }
    assert_eq!(call(&server, "GET", "/v1/gyros", &admin, "").await.status, 200);
}

#[tokio::test]
async fn a_token_that_asks_for_too_much_is_put_off_and_others_are_not() {
    let server = Server::start_with(&[("GYROWATCH_ACCESS__REQUESTS_PER_SECOND", "5")]).await;
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    let (busy, _) = token(&server, &admin, "station", json!({})).await;
    let mut statuses = Vec::new();
    for _ in 0..20 {
        statuses.push(call(&server, "GET", "/v1/gyros", &busy, "").await.status);
    }
    assert!(statuses.starts_with(&[200; 5]) && statuses.contains(&429), "{statuses:?}");
    assert_eq!(call(&server, "GET", "/v1/gyros", &admin, "").await.status, 200);
    tokio::time::sleep(Duration::from_millis(1100)).await;
    assert_eq!(call(&server, "GET", "/v1/gyros", &busy, "").await.status, 200);
}

/// `gyrowatch token …` on the database of a service.
fn token_command(dir: &Path, arguments: &[&str]) -> (bool, String) {
    let (status, said) = on_database(&[&["token"], arguments].concat(), dir);
    (status == Some(0), said)
}

#[test]
fn a_token_for_a_database_that_is_not_there_makes_it_and_says_so() {
    let dir = tempfile::TempDir::new().unwrap();
    for order in [&["list"][..], &["revoke", "17"]] {
        let (done, said) = token_command(dir.path(), order);
        assert!(!done && said.contains("there is no database sqlite://"), "{said}");
        assert!(!dir.path().join("gyrowatch.db").exists());
    }
    let create = ["create", "Li", "--role", "engineer"];
    let (made, said) = token_command(dir.path(), &create);
    assert!(made && said.contains("gyrowatch.db: making it"), "{said}");
    let (made, said) = token_command(dir.path(), &create);
    assert!(made && !said.contains("making it"), "{said}");
}

fn secret(said: &str) -> String {
    said.lines().find(|line| line.starts_with("gyw_")).unwrap_or_else(|| panic!("{said}")).to_owned()
}

#[tokio::test]
async fn the_command_line_makes_lists_and_revokes_tokens_while_the_service_runs() {
    let server = Server::start().await;
    let (made, said) =
        token_command(server.dir(), &["create", "the lab", "--role", "station", "--station", "ST-1", "--days", "30"]);
    assert!(made, "{said}");
    let lab = secret(&said);
    assert_eq!(call(&server, "GET", "/v1/gyros", &lab, "").await.status, 200, "it counts at once");
    tokio::time::sleep(Duration::from_millis(1200)).await;
    assert_eq!(server.get("/v1/gyros").await.status, 401);
    let (_, listed) = token_command(server.dir(), &["list"]);
    assert!(listed.contains("the lab") && listed.contains("ST-1") && listed.contains("until"), "{listed}");
    assert!(!listed.contains(&lab[17..]), "{listed}");
    let (revoked, said) = token_command(server.dir(), &["revoke", &lab[4..17]]);
    assert!(revoked && said.contains("revoked"), "{said}");
    tokio::time::sleep(Duration::from_millis(1500)).await;
    assert_eq!(call(&server, "GET", "/v1/gyros", &lab, "").await.status, 401);
    for (id, why) in [("0000000000000", "there is no token 0000000000000"), ("nope", "is no identifier of a token")] {
        let (revoked, said) = token_command(server.dir(), &["revoke", id]);
        assert!(!revoked && said.contains(why) && !said.contains("the database"), "{said}");
    }
    assert!(!token_command(server.dir(), &["create", "x", "--role", "king"]).0);
    let limited = token_command(server.dir(), &["create", "x", "--role", "engineer", "--station", "ST-2"]);
    assert!(!limited.0 && limited.1.contains("--station") && limited.1.contains("role station"), "{}", limited.1);
    assert!(
        !token_command(server.dir(), &["create", "x", "--role", "admin", "--expires-at", "2020-01-01T00:00:00Z"]).0
    );
}

#[tokio::test]
async fn elsewhere_than_on_this_machine_it_listens_only_with_a_token_and_with_plain_words_or_tls() {
    const WORDS: &str = "anybody on the network can read tokens and records, and change them";
    let dir = tempfile::tempdir().unwrap();
    let serve = |words: &str| {
        let mut command = beside(dir.path());
        command.arg("serve");
        command.env("GYROWATCH_LISTEN", "0.0.0.0:0").env("GYROWATCH_SERVER__PLAIN_HTTP", words);
        command
    };
    let refused = |words: &str, because: &[&str]| {
        let output = serve(words).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(because.iter().all(|part| said.contains(part)), "{said}");
    };
    refused("", &["server.listen", "in the open", WORDS]);
    refused("yes", &["server.plain_http"]);
    refused(WORDS, &["there is no token", "gyrowatch token create"]);
    let (made, said) = token_command(dir.path(), &["create", "first", "--role", "admin"]);
    assert!(made, "{said}");
    refused("", &["server.listen"]);
    let mut child = serve(WORDS).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut line = String::new();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(child.stdout.take().unwrap()), &mut line).unwrap();
    assert!(line.contains("http://0.0.0.0:"), "{line}");
    child.kill().unwrap();
    child.wait().unwrap();
}

#[tokio::test]
async fn everything_that_people_do_is_in_the_audit_trail_with_who_and_what_before_and_after() {
    let server = Server::start().await;
    let (admin, admin_id) = token(&server, "", "admin", json!({})).await;
    let (engineer, engineer_id) = token(&server, &admin, "engineer", json!({})).await;
    let mut newest = String::new();
    for (at, shift) in [("2026-03-01T08:00:00Z", 0.0), ("2026-03-08T08:00:00Z", 0.5)] {
        let mut record = document("paper.json");
        record["calibrated_at"] = at.into();
        let g = record["gyros"][0]["g_pulse_per_s_g0"][0].as_f64().unwrap();
        record["gyros"][0]["g_pulse_per_s_g0"][0] = (g + shift).into();
        let answer = call(&server, "POST", "/v1/records", &engineer, &record.to_string()).await.created();
        newest = answer["id"].as_str().unwrap().to_owned();
    }
    let alerts = call(&server, "GET", "/v1/alerts", &engineer, "").await.json();
    let alert = alerts["alerts"][0]["id"].as_str().unwrap_or_else(|| panic!("{alerts}")).to_owned();
    let doings = [
        ("POST", format!("/v1/alerts/{alert}/acknowledge"), json!({ "by": "Li", "reason": "seen" }), 200),
        (
            "POST",
            format!("/v1/alerts/{alert}/silence"),
            json!({ "by": "Li", "reason": "known", "until": "2099-01-01T00:00:00Z" }),
            200,
        ),
        ("POST", "/v1/gyros/LFG-0101/baseline".into(), json!({ "reason": "repaired" }), 201),
        ("POST", "/v1/gyros/LFG-0101/events".into(), json!({ "event": "transport", "reason": "moved" }), 201),
        ("POST", format!("/v1/records/{newest}/void"), json!({ "author": "Li", "reason": "wrong table" }), 200),
    ];
    for (method, path, body, status) in &doings {
        let answer = call(&server, method, path, &engineer, &body.to_string()).await;
        assert_eq!(answer.status, *status, "{path}: {}", answer.text());
    }
    let hook = json!({ "name": "h", "kind": "standard-webhooks", "url": "http://127.0.0.1:9/with-a-token-in-it" });
    let hook = call(&server, "POST", "/v1/hooks", &admin, &hook.to_string()).await.created();
    let hook = format!("/v1/hooks/{}", hook["id"].as_str().unwrap());
    assert_eq!(call(&server, "PATCH", &hook, &admin, r#"{"name":"other"}"#).await.status, 200);
    assert_eq!(call(&server, "DELETE", &hook, &admin, "").await.status, 204);
    assert_eq!(call(&server, "DELETE", &format!("/v1/tokens/{engineer_id}"), &admin, "").await.status, 204);

    let trail = call(&server, "GET", "/v1/audit", &admin, "").await.json();
    let lines = trail["lines"].as_array().unwrap();
    let acts: Vec<&str> = lines.iter().rev().map(|line| line["action"].as_str().unwrap()).collect();
    let expected = [
        "create token",
        "create token",
        "store",
        "store",
        "acknowledge",
        "silence",
        "mark event",
        "mark event",
        "void",
        "create hook",
        "change hook",
        "delete hook",
        "revoke token",
    ];
    assert_eq!(acts, expected);
    let line = |act: &str| lines.iter().find(|line| line["action"] == act).unwrap();
    let acknowledged = line("acknowledge");
    assert_eq!((&acknowledged["who"], &acknowledged["token"]), (&json!("the engineer"), &json!(engineer_id)));
    assert_eq!(acknowledged["source"], "127.0.0.1");
    assert!(acknowledged["before"]["acknowledged"] != acknowledged["after"]["acknowledged"], "{acknowledged}");
    let changed = line("change hook");
    assert_eq!((&changed["before"]["name"], &changed["after"]["name"]), (&json!("h"), &json!("other")));
    assert_eq!(changed["after"]["origin"], "http://127.0.0.1:9");
    assert!(line("delete hook")["after"].is_null() && line("create hook")["before"].is_null());
    let revoked = line("revoke token");
    assert!(revoked["before"]["revoked_at"].is_null() && revoked["after"]["revoked_at"].is_string());
    assert_eq!((&lines.last().unwrap()["who"], &lines.last().unwrap()["token"]), (&json!("local"), &Value::Null));
    for secret in ["with-a-token-in-it", &admin[17..], &engineer[17..], "whsec_"] {
        assert!(!trail.to_string().contains(secret), "{secret}");
    }

    let by_admin = call(&server, "GET", "/v1/audit?who=the%20admin&limit=2", &admin, "").await.json();
    assert_eq!(by_admin["lines"].as_array().unwrap().len(), 2);
    let next = by_admin["next"].as_str().unwrap();
    let rest = call(&server, "GET", &format!("/v1/audit?who=the%20admin&cursor={next}"), &admin, "").await.json();
    assert_eq!((rest["lines"].as_array().unwrap().len(), &rest["next"]), (3, &Value::Null));
    let on_gyro = call(&server, "GET", "/v1/audit?subject=gyros/LFG-0101&action=mark%20event", &admin, "").await.json();
    assert_eq!(on_gyro["lines"].as_array().unwrap().len(), 2);
    let none = call(&server, "GET", "/v1/audit?to=2020-01-01T00:00:00Z", &admin, "").await.json();
    assert!(none["lines"].as_array().unwrap().is_empty());
    let csv = call(&server, "GET", "/v1/audit?format=csv", &admin, "").await;
    assert!(csv.content_type.starts_with("text/csv") && csv.text().lines().count() == 14, "{}", csv.text());
    assert!(csv.text().contains(&admin_id));
    assert_eq!(call(&server, "GET", "/v1/audit?format=xml", &admin, "").await.status, 400);
}

/// What an answer says of who sent it, without the token's identifier and the program's version.
fn sender(answer: &Answer) -> (String, String, String) {
    assert_eq!(answer.status, 200, "{}", answer.text());
    let sent_by = answer.json()["sent_by"].clone();
    let text = |key: &str| sent_by[key].as_str().unwrap_or_else(|| panic!("{key} of {sent_by}")).to_owned();
    (text("name"), text("address"), text("agent").split('/').next().unwrap().to_owned())
}

#[tokio::test]
async fn who_sent_something_is_kept_with_it_shown_and_audited() {
    let server = Server::start().await;
    let bench = lab::bench("LFG-0101", "2026-03-02T08:00:00Z", 1.0, 2.0);
    let first = server.post_json("/v1/records", &paper_record(1, 0)).await.json();
    let first = format!("/v1/records/{}", first["id"].as_str().unwrap());
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    let (station, id) = token(&server, &admin, "station", json!({})).await;
    let shown = call(&server, "GET", &first, &admin, "").await;
    assert_eq!(sender(&shown), ("local".into(), "127.0.0.1".into(), "gyrowatch".into()));
    assert!(shown.json()["sent_by"]["token"].is_null());

    let mut places = vec![];
    for (path, body) in [
        ("records", paper_record(2, 0).to_string()),
        ("bench-results", bench.to_string()),
        ("campaigns", data("practice/campaign-00.json")),
    ] {
        let stored = call(&server, "POST", &format!("/v1/{path}"), &station, &body).await.created();
        places.push(format!("{path}/{}", stored["id"].as_str().unwrap()));
    }
    let lines = (1..=40).map(|minute| paper_record(2, minute).to_string() + "\n").collect::<String>();
    let bearer = format!("Bearer {station}");
    let agent = format!("agent {}\u{e9}", "x".repeat(500));
    let headers =
        [("authorization", bearer.as_str()), ("content-type", "application/x-ndjson"), ("user-agent", agent.as_str())];
    let imported = server.call("POST", "/v1/import", &headers, lines).await.text();
    for place in &places {
        let shown = call(&server, "GET", &format!("/v1/{place}"), &admin, "").await;
        assert_eq!(sender(&shown), ("the station".into(), "127.0.0.1".into(), "gyrowatch".into()), "{place}");
        assert_eq!(shown.json()["sent_by"]["token"], id.as_str());
        let lines =
            call(&server, "GET", &format!("/v1/audit?subject={place}"), &admin, "").await.json()["lines"].clone();
        assert_eq!((&lines[0]["action"], &lines[0]["who"]), (&json!("store"), &json!("the station")), "{place}");
        assert!(lines[0]["agent"].as_str().unwrap().starts_with("gyrowatch/"), "{lines}");
        if let Some(page) = place.strip_prefix("records").or(place.strip_prefix("campaigns")) {
            let page = format!("/{}{page}", place.split('/').next().unwrap());
            let page = call(&server, "GET", &page, &admin, "").await.text();
            assert!(page.contains("sent by") && page.contains("the station (127.0.0.1, gyrowatch/"), "{page}");
        }
    }
    for line in imported.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        let shown = call(&server, "GET", &format!("/v1/records/{}", line["id"].as_str().unwrap()), &admin, "").await;
        let (name, _, agent) = sender(&shown);
        assert_eq!((name.as_str(), agent.chars().count()), ("the station", 200));
    }
    // One line for all that came together.
    let trail = call(&server, "GET", "/v1/audit?action=store&subject=records", &admin, "").await.json();
    let counts = trail["lines"].as_array().unwrap().iter().map(|line| line["after"]["stored"].as_u64().unwrap());
    assert_eq!(counts.sum::<u64>(), 40, "{trail}");
    // What was there before is still the first sender's.
    assert_eq!(call(&server, "POST", "/v1/records", &admin, &paper_record(1, 0).to_string()).await.status, 200);
    assert_eq!(sender(&call(&server, "GET", &first, &admin, "").await).0, "local");
}

#[tokio::test]
async fn the_audit_trail_cannot_be_rewritten() {
    let server = Server::start().await;
    let _ = token(&server, "", "admin", json!({})).await;
    let mut connection = behind::open(&server.database()).await;
    for sql in ["UPDATE audit SET who = 'nobody'", "DELETE FROM audit"] {
        let error = sqlx::query(sql).execute(&mut connection).await.unwrap_err().to_string();
        assert!(error.contains("only ever added to"), "{error}");
    }
}

/// A client that trusts one certificate.
fn trusting(certificate: &str) -> reqwest::Client {
    let certificate = reqwest::Certificate::from_pem(data(certificate).as_bytes()).unwrap();
    let client = gyrowatch::system::http_client(Duration::from_secs(20), Duration::from_secs(60));
    client.tls_certs_only([certificate]).pool_max_idle_per_host(0).build().unwrap()
}

#[tokio::test]
async fn over_tls_a_new_certificate_is_shown_without_a_restart_and_a_bad_one_never() {
    let files = tempfile::tempdir().unwrap();
    let (certificate, key) = (files.path().join("tls.crt"), files.path().join("tls.key"));
    let install = |name: &str| {
        std::fs::write(&certificate, data(&format!("tls/{name}.crt"))).unwrap();
        std::fs::write(&key, data(&format!("tls/{name}.key"))).unwrap();
    };
    install("one");
    let server = Server::start_with(&[
        ("GYROWATCH_SERVER__TLS_CERTIFICATE", certificate.to_str().unwrap()),
        ("GYROWATCH_SERVER__TLS_KEY", key.to_str().unwrap()),
    ])
    .await;
    let url = format!("https://{}/healthz", server.address());
    let (one, two) = (trusting("tls/one.crt"), trusting("tls/two.crt"));
    let well = one.get(&url).send().await.unwrap();
    assert_eq!(
        (well.status().as_u16(), well.headers()["strict-transport-security"].to_str().unwrap()),
        (200, "max-age=31536000")
    );
    assert!(two.get(&url).send().await.is_err(), "another certificate is not trusted");
    assert!(one.get(url.replace("https", "http")).send().await.is_err(), "nothing is said in the open");
    let made = one.post(url.replace("healthz", "v1/tokens")).header("content-type", "application/json");
    let made = made.body(r#"{"name":"a","role":"admin"}"#).send().await.unwrap().text().await.unwrap();
    let token = serde_json::from_str::<Value>(&made).unwrap()["token"].as_str().unwrap().to_owned();
    let entered = one.post(url.replace("healthz", "sign-in")).header("content-type", FORM);
    let entered = entered.body(format!("token={token}")).send().await.unwrap();
    assert!(entered.headers()["set-cookie"].to_str().unwrap().ends_with("; Secure"));

    std::fs::write(&key, "no key").unwrap();
    tokio::time::sleep(Duration::from_millis(2500)).await;
    assert_eq!(one.get(&url).send().await.unwrap().status(), 200, "the certificate before stays");
    assert!(server.log().contains("cannot be used"), "{}", server.log());
    install("two");
    tokio::time::sleep(Duration::from_millis(2500)).await;
    assert_eq!(two.get(&url).send().await.unwrap().status(), 200);
    assert!(one.get(&url).send().await.is_err());
}

#[tokio::test(flavor = "multi_thread")]
async fn an_authoritys_own_certificate_is_given_up_at_once_and_said_in_words() {
    let [certificate, key] = ["crt", "key"].map(|kind| support::data_path(&format!("tls/authority.{kind}")));
    let server = Server::start_with(&[
        ("GYROWATCH_SERVER__TLS_CERTIFICATE", certificate.to_str().unwrap()),
        ("GYROWATCH_SERVER__TLS_KEY", key.to_str().unwrap()),
    ])
    .await;
    let begun = std::time::Instant::now();
    let mut import = gyrowatch();
    import.args(["import", "--url", &format!("https://{}", server.address()), "--ca-file"]).arg(&certificate);
    let output = import.arg(root().join("docs/examples/record.json")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && said.contains("certificate of an authority (CA:TRUE)"), "{said}");
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
}

#[test]
fn a_certificate_that_cannot_be_used_stops_the_start_and_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let (one, two) = (support::data_path("tls/one.crt"), support::data_path("tls/two.key"));
    for (certificate, key, named) in [
        (Some(one.to_str().unwrap()), None, "server.tls_key"),
        (None, Some(two.to_str().unwrap()), "server.tls_certificate"),
        (Some("nowhere.crt"), Some(two.to_str().unwrap()), "nowhere.crt"),
        (Some(one.to_str().unwrap()), Some("nowhere.key"), "nowhere.key"),
        (Some(one.to_str().unwrap()), Some(two.to_str().unwrap()), "do not go together"),
        (Some(two.to_str().unwrap()), Some(two.to_str().unwrap()), "holds no certificate"),
    ] {
        let mut command = gyrowatch();
        command.arg("serve").current_dir(dir.path()).env("GYROWATCH_LISTEN", "127.0.0.1:0");
        command.envs(certificate.map(|file| ("GYROWATCH_SERVER__TLS_CERTIFICATE", file)));
        command.envs(key.map(|file| ("GYROWATCH_SERVER__TLS_KEY", file)));
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(named), "{said}");
    }
}

/// Addresses of this service in an attribute of a page's elements, as a browser would follow them.
fn addresses(page: &str, attribute: &str) -> Vec<String> {
    let opening = format!(" {attribute}=\"");
    let found = page.split(&opening).skip(1).map(|rest| rest.split('"').next().unwrap());
    found.filter(|at| at.starts_with('/')).map(|at| at.replace("&amp;", "&")).collect()
}

#[tokio::test]
async fn pages_offer_to_everybody_what_they_may_do_and_nothing_else() {
    let server = Server::start().await;
    server.stores_half_a_year().await;
    let hook = json!({ "kind": "cloudevents", "url": "http://127.0.0.1:9/" });
    assert_eq!(server.post_json("/v1/hooks", &hook).await.status, 201);
    let (admin, _) = token(&server, "", "admin", json!({})).await;
    let reads = |role: &str| matches!(role, "viewer" | "station");
    for role in ["viewer", "station", "engineer", "admin"] {
        let (token, _) = token(&server, &admin, role, json!({})).await;
        let cookie = cookie(&sign_in(&server, &token).await);
        let headers = [("cookie", cookie.as_str()), ("accept", "text/html")];
        // Everything that can be reached, not only what the first pages offer.
        let (mut open, mut seen, mut offers) = (vec!["/".to_owned()], BTreeSet::new(), BTreeSet::new());
        while let Some(path) = open.pop() {
            let is_page = !["/v1/", "/assets/"].iter().any(|start| path.starts_with(start));
            if !seen.insert(path.split(['?', '#']).next().unwrap().to_owned()) || !is_page {
                continue;
            }
            let answer = server.call("GET", &path, &headers, "").await;
            let to_sign_in = answer.headers.get("location").is_some_and(|at| at.to_str().unwrap().contains("&takes="));
            assert!(answer.status != 403 && !to_sign_in, "{path} is offered to the role {role}, and refused");
            if answer.status == 200 {
                let page = answer.text();
                let links = addresses(&page, "href");
                offers.extend(links.iter().cloned().chain(addresses(&page, "action")));
                open.extend(links.into_iter().filter(|at| !at.starts_with("/preference")));
            }
        }
        let orders = server.call("GET", "/diagnoses", &headers, "").await.text();
        assert_eq!(orders.contains("action=\"/diagnoses\" method=\"post\""), !reads(role));
        // The book and the description of the API tell of everything and offer nothing.
        let tells = |at: &&String| ["/book/", "/docs/"].iter().any(|start| at.starts_with(start));
        let offered = offers.iter().filter(|at| !tells(at)).map(|at| at.split('?').next().unwrap());
        let any = |part: &str| offered.clone().any(|at| at.contains(part));
        assert!(any("/gyros/LFG-0101"), "{offers:?}");
        assert_eq!(any("/import"), role != "viewer", "{role}: {offers:?}");
        let engineers = ["/void", "/acknowledge", "/silence", "/events/new", "/hooks", "/test"];
        assert_eq!(engineers.map(any), [!reads(role); 6], "{role}: {offers:?}");
        assert_eq!(["/hooks/new", "/enabled", "/delete"].map(any), [role == "admin"; 3], "{role}: {offers:?}");
    }
    let (token, _) = token(&server, &admin, "station", json!({})).await;
    let cookie = cookie(&sign_in(&server, &token).await);
    let headers = [("cookie", cookie.as_str()), ("accept", "text/html")];
    let sent_on = server.call("GET", "/hooks", &headers, "").await;
    let place = sent_on.headers["location"].to_str().unwrap().to_owned();
    assert_eq!((sent_on.status, place.as_str()), (303, "/sign-in?back=%2Fhooks&takes=engineer"));
    let page = server.call("GET", &place, &headers, "").await;
    assert!(page.status == 200 && page.text().contains("Sign in with one of the role: engineer"), "{}", page.text());
}
