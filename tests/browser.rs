//! People at the pages, in a real browser: they find a gyro, zoom, switch the method, export, read a diagnosis,
//! import a file with errors. Whatever they do, the console does not complain and no request leaves the service.

use std::io::{BufRead, BufReader};

use crate::chromium::{self, Browser};
use crate::command::beside;
use crate::nginx::Nginx;
use crate::prelude::*;

/// `gyrowatch demo`: two years of a fleet, the paper's tables, campaigns with something hidden in them.
struct Demo {
    _child: Running,
    base: String,
    dir: tempfile::TempDir,
}

impl Demo {
    fn start() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let mut child = gyrowatch()
            .args(["demo", "--listen", "127.0.0.1:0", "--database", "demo.db"])
            .current_dir(dir.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        let mut base = String::new();
        for line in lines {
            if let Some(address) = line.strip_prefix("gyrowatch listens on ") {
                base = address.to_owned();
            }
            if line.contains("Ctrl-C") {
                break;
            }
        }
        assert!(!base.is_empty(), "the demo names its address");
        Self { _child: Running(child), base, dir }
    }
}

/// Waits until a download is whole, and reads it.
async fn downloaded(dir: &Path, name: &str) -> Vec<u8> {
    let file = dir.join(name);
    for _ in 0..400 {
        // Chromium takes the name with an empty file first, and puts the whole one in its place.
        match std::fs::read(&file) {
            Ok(bytes) if !bytes.is_empty() => return bytes,
            _ => {}
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let there: Vec<_> = std::fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    panic!("{name} was never downloaded; there are {there:?}");
}

/// The demonstration, and a browser of that size which looks at it; none where there is no browser.
async fn at_the_demo(width: u32, height: u32) -> Option<(Demo, Browser)> {
    if !chromium::is_installed() {
        return None;
    }
    let demo = Demo::start();
    let browser = Browser::open(&demo.base, demo.dir.path()).await;
    browser.look(width, height, false).await;
    Some((demo, browser))
}

/// Days that the pictures of a gyro's page show.
const DAYS: &str = "(({from, until}) => (until - from) / 864e5)(document.querySelector('#history .picture').dataset)";

async fn shown_days(browser: &Browser) -> f64 {
    browser.eval(DAYS).await.as_f64().unwrap()
}

#[tokio::test]
async fn an_engineer_finds_a_gyro_zooms_switches_the_method_and_exports() {
    let Some((demo, browser)) = at_the_demo(1280, 1000).await else { return };
    browser.goto("/").await;
    // With the keyboard alone: a slash leads to the search, and one gyro is there at once.
    browser
        .eval("document.body.dispatchEvent(new KeyboardEvent('keydown', {key: '/', bubbles: true, cancelable: true}))")
        .await;
    assert_eq!(browser.eval("document.activeElement.id").await, "find");
    browser.type_into("#find", "lfg-0004\n").await;
    browser.wait("location.pathname == '/gyros/LFG-0004'").await;
    browser.wait("document.querySelector('#history')").await;
    browser.sees("Take it out:").await;
    browser.click("#verdicts summary").await;
    browser.sees("deg/(h g0) above its baseline").await;
    browser.sees("Confirmed by a second campaign.").await;
    // The pictures are above the fold.
    let foot = "document.querySelector('#history .picture').getBoundingClientRect().bottom + scrollY";
    let foot = browser.eval(foot).await.as_f64().unwrap();
    assert!(foot < 900.0, "the first plot ends at {foot}");

    browser.click("#verdicts a[href*='/acknowledge']").await;
    browser.wait("document.querySelector('form.deed')").await;
    browser.type_into("input[name=by]", "Li Wei").await;
    browser.type_into("textarea[name=reason]", "ordered a bench test").await;
    browser.click("form.deed button").await;
    browser.wait("location.pathname == '/gyros/LFG-0004' && document.querySelector('#history')").await;
    browser.sees("by Li Wei: ordered a bench test").await;

    let whole = shown_days(&browser).await;
    assert!(whole > 600.0, "two years are shown: {whole} days");
    let place = browser.eval(
        "(() => { const area = document.querySelector('#history svg.area'); area.scrollIntoView({block: 'center'}); \
        const r = area.getBoundingClientRect(); return [r.left, r.top, r.width, r.height] })()",
    );
    let place = place.await;
    let [left, top, width, height] = [0, 1, 2, 3].map(|i| place[i].as_f64().unwrap());
    let at = |x: f64, y: f64| (left + x * width, top + y * height);
    browser.drag(at(0.5, 0.2), at(0.75, 0.7)).await;
    browser.wait(&format!("Math.abs({DAYS} / {whole} - 0.26) < 0.03")).await;
    assert_eq!(browser.eval("location.search.includes('from=') && location.search.includes('to=')").await, true);
    // Backwards as a browser goes.
    browser.eval("history.back()").await;
    browser.wait(&format!("{DAYS} > {}", 0.9 * whole)).await;

    // By keyboard from record to record, and into one.
    browser.eval("document.querySelector('#history .picture').focus()").await;
    let newest = "document.querySelector('#history .said').textContent";
    browser.press("ArrowLeft").await;
    browser.wait(&format!("{newest}.includes('confirmed')")).await;
    let last = browser.eval(newest).await;
    browser.press("ArrowLeft").await;
    browser.wait(&format!("{newest} && {newest} != {last}")).await;
    browser.press("Enter").await;
    browser.wait("location.pathname.startsWith('/records/')").await;
    browser.goto("/gyros/LFG-0004").await;

    browser.click("#history [data-save]").await;
    let picture = downloaded(demo.dir.path(), "LFG-0004.png").await;
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 10_000);
    browser.click("a[download$='D_I.csv']").await;
    let csv = String::from_utf8(downloaded(demo.dir.path(), "LFG-0004-D_I.csv").await).unwrap();
    assert!(csv.starts_with("serial,coefficient,unit,calibrated_at,value,sd,") && csv.lines().count() > 30, "{csv}");

    browser.click(".tabs a[href*=published]").await;
    browser.wait("document.querySelector('.tabs [aria-current]') && location.search.includes('published')").await;
    browser.wait("document.querySelectorAll('.tabs [aria-current]')[1].textContent.includes('published')").await;
    browser.click(".tabs a[href*=bench]").await;
    browser.wait("document.querySelectorAll('.tabs [aria-current]')[1].textContent == 'bench'").await;
    assert_eq!(browser.eval("document.querySelectorAll('#history .record').length").await, 0);
    assert_eq!(
        browser.eval("document.querySelectorAll('#history .bench0, #history .bench1').length").await,
        6,
        "two pictures and the legend"
    );
    browser.click(".tabs a[href*=absolute]").await;
    browser.wait("location.search.includes('axis=absolute') && document.querySelector('.picture.bare')").await;
    browser.has_behaved().await;
}

/// The console complains where the content security policy forbids what a page does, and any request beside the
/// prefix is a fault.
#[tokio::test]
async fn under_a_prefix_an_engineer_signs_in_sees_a_plot_and_reads_the_api() {
    if !chromium::is_installed() || !support::required("nginx") {
        return;
    }
    let server = Server::start_with(&[("GYROWATCH_SERVER__BASE_PATH", "/gyrowatch")]).await;
    let made = beside(server.dir()).args(["token", "create", "Li", "--role", "engineer"]).output().unwrap();
    let token = String::from_utf8(made.stdout).unwrap();
    let bearer = format!("Bearer {}", token.trim());
    let headers = [("authorization", bearer.as_str()), ("content-type", "application/json")];
    assert_eq!(server.call("POST", "/v1/records", &headers, data("paper.json")).await.status, 201);
    let location = format!("location /gyrowatch/ {{ proxy_pass http://{}; }}", server.address());
    let nginx = Nginx::start(&location, false);
    let base = format!("http://{}/gyrowatch", nginx.address());
    let dir = tempfile::tempdir().unwrap();
    let browser = Browser::open(&base, dir.path()).await;
    browser.look(1280, 1000, false).await;
    browser.goto("/gyros/LFG-0101").await;
    browser.wait("location.pathname == '/gyrowatch/sign-in'").await;
    browser.type_into("input[name=token]", &format!("{}\n", token.trim())).await;
    browser.wait("location.pathname == '/gyrowatch/gyros/LFG-0101' && document.querySelector('#history .point')").await;
    browser.click("a[href='/gyrowatch/docs']").await;
    browser.click("article a[href='/gyrowatch/docs/records#post_record']").await;
    browser.wait("location.hash == '#post_record' && document.querySelector('section:target table')").await;
    browser.has_behaved().await;
}

#[tokio::test]
async fn a_plot_with_one_calibration_shows_a_month_and_the_budget_about_it() {
    let Some((_demo, browser)) = at_the_demo(1280, 1000).await else { return };
    browser.goto("/gyros/PAPER-T4-G1").await;
    assert!((shown_days(&browser).await - 30.0).abs() < 1e-6);
    let figures = "[...document.querySelectorAll('#history .limit')].slice(0, 4).map((e) => e.textContent).join()";
    assert_eq!(browser.eval(figures).await, "+0.010,-0.010,+100 %,-100 %");
    browser.sees("not enough data").await;
    browser.has_behaved().await;
}

#[tokio::test]
async fn a_metrologist_reads_what_was_hidden_in_a_campaign() {
    if !chromium::is_installed() {
        return;
    }
    let server = Server::start().await;
    let stored = server.post("/v1/campaigns", "application/json", data("practice/campaign-09.json")).await;
    assert_eq!(stored.status, 201);
    let browser = Browser::open(&server.url(""), server.dir()).await;
    browser.look(1280, 1000, false).await;
    browser.goto("/fleet?q=IMU-9009").await;
    browser.click("table.fleet a[href^='/imus/']").await;
    browser.wait("location.pathname == '/imus/IMU-9009'").await;
    browser.click("a[href$='/diagnosis']").await;
    browser.wait("location.pathname.endsWith('/diagnosis') && !document.querySelector('#waiting')").await;
    for there in [
        "The residuals are at the noise floor.",
        "warm-up after power-up",
        "unequal moments of inertia",
        "What else was tried",
    ] {
        browser.sees(there).await;
    }
    // The key says that both causes are in G3 alone: there the map is darkest.
    let darkest = browser.eval(
        "[...document.querySelectorAll('.heat:has(title)')].sort((a, b) => b.getAttribute('fill-opacity') - a.getAttribute('fill-opacity'))[0].textContent",
    );
    assert!(darkest.await.as_str().unwrap().starts_with("G3, dwell "));
    browser.has_behaved().await;
}

#[tokio::test]
async fn an_operator_sees_what_is_wrong_with_a_file_before_anything_is_stored() {
    if !chromium::is_installed() {
        return;
    }
    let server = Server::start().await;
    let good = document("paper.json");
    let mut bad = good.clone();
    bad["gyros"][1]["e_pulse_per_arcsec"] = json!([0.0, 0.0, 0.0]);
    bad["calibrated_at"] = "yesterday".into();
    let file = server.dir().join("calibrations.ndjson");
    std::fs::write(&file, format!("{good}\n{bad}\nnot a document\n")).unwrap();
    let browser = Browser::open(&server.url(""), server.dir()).await;
    browser.look(1280, 1000, false).await;
    browser.goto("/import").await;
    let before = server.holdings().await;
    browser.type_into("input[type=file]", file.to_str().unwrap()).await;
    browser.wait("document.querySelector('.preview')").await;
    for there in [
        "1 can be stored · 2 cannot",
        "Line 2 · refused",
        "calibrated_at: ",
        "gyro 2, e_pulse_per_arcsec: ",
        "Preview · calibrations.ndjson",
        "Line 3 · refused",
        "2.957643",
    ] {
        browser.sees(there).await;
    }
    assert_eq!(server.holdings().await, before, "a preview stores nothing");
    // A table that may have been cut inside its last number says so before it is stored.
    let table = std::fs::read_to_string(root().join("docs/examples/march.csv")).unwrap();
    let (whole, cut) = (server.dir().join("whole.csv"), server.dir().join("cut.csv"));
    std::fs::write(&whole, format!("{}\n", table.trim_end())).unwrap();
    std::fs::write(&cut, table.trim_end()).unwrap();
    let said = "document.querySelector('.preview').innerText.includes('does not end with a line break')";
    for (path, is_cut) in [(cut, true), (whole, false)] {
        browser.goto("/import").await;
        browser.type_into("input[type=file]", path.to_str().unwrap()).await;
        browser.wait("document.querySelector('form.confirm')").await;
        assert_eq!(browser.eval(said).await, is_cut, "{}", path.display());
    }
    browser.goto("/import").await;
    browser.type_into("input[type=file]", file.to_str().unwrap()).await;
    browser.wait("document.querySelector('.preview')").await;
    browser.click("form.confirm button").await;
    browser.wait("document.querySelector('.preview a[href^=\"/records/\"]')").await;
    browser.sees("Line 1 · stored:").await;
    browser.click(".preview a").await;
    browser.wait("location.pathname.startsWith('/records/')").await;
    browser.sees("2.957643").await;

    // A campaign's CSV, its fault named by line and column.
    browser.goto("/import").await;
    browser.type_into("textarea[name=text]", "# imu: IMU-1\nphase,start_s\nstatic,0\n").await;
    browser.click("form.import button").await;
    browser.wait("document.querySelector('.fault')").await;
    browser.has_behaved().await;
}

/// Fills in who and why, and sends the form.
async fn says_why(browser: &Browser, by: &str, reason: &str) {
    browser.wait("document.querySelector('form.deed')").await;
    browser.type_into("input[name=by]", by).await;
    browser.type_into("textarea[name=reason]", reason).await;
    browser.click("form.deed button").await;
}

#[tokio::test]
async fn an_engineer_voids_a_calibration_notes_a_repair_and_starts_a_baseline() {
    if !chromium::is_installed() {
        return;
    }
    let server = Server::start().await;
    let mut record = document("paper.json");
    for month in 1..=4 {
        record["calibrated_at"] = format!("2026-0{month}-01T08:00:00Z").into();
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    }
    let browser = Browser::open(&server.url(""), server.dir()).await;
    browser.look(1280, 1000, false).await;
    browser.goto("/gyros/LFG-0101").await;
    let drawn = "location.pathname == '/gyros/LFG-0101' && document.querySelector('#history .point')";
    let points = "document.querySelector('#history .picture').querySelectorAll('.point').length";
    browser.wait(drawn).await;
    assert_eq!(browser.eval(points).await, 4);

    browser.click("#calibrations a[href*='/void']").await;
    browser.wait("document.querySelector('form.deed')").await;
    browser.sees("It counts no more").await;
    // Without the tick the browser itself does not send the form.
    browser.type_into("input[name=by]", "Li Wei").await;
    browser.type_into("textarea[name=reason]", "table was not level").await;
    browser.click("form.deed button").await;
    assert_eq!(browser.eval("location.pathname.endsWith('/void')").await, true);
    browser.click("input[name=confirm]").await;
    browser.click("form.deed button").await;
    browser.wait(drawn).await;
    assert_eq!(browser.eval(points).await, 3);
    browser.sees("Li Wei: table was not level").await;
    browser.click("#happenings a[href^='/records/']").await;
    browser.wait("location.pathname.startsWith('/records/')").await;
    browser.sees("Voided: it counts no more.").await;

    browser.goto("/gyros/LFG-0101").await;
    browser.click("a.action[href$='/events/new']").await;
    browser.wait("document.querySelector('select[name=event]')").await;
    browser.eval("(document.querySelector('select[name=event]').value = 'repair')").await;
    says_why(&browser, "Zhao Min", "bearing replaced").await;
    browser.wait(drawn).await;
    browser.sees("bearing replaced (Zhao Min)").await;

    browser.click("a.action[href*='event=baseline']").await;
    says_why(&browser, "Zhao Min", "as it left the workshop").await;
    browser.wait(drawn).await;
    browser.sees("as it left the workshop (Zhao Min)").await;
    let marks = "document.querySelector('ol.flags').innerText";
    let marks = browser.eval(marks).await;
    assert!(marks.as_str().unwrap().contains("repair") && marks.as_str().unwrap().contains("new baseline"), "{marks}");
    browser.has_behaved().await;
}

#[tokio::test]
async fn an_integrator_sets_up_a_hook_tries_it_and_sends_a_message_again() {
    if !chromium::is_installed() {
        return;
    }
    let (server, target) = (Server::start().await, Receiver::start().await);
    let browser = Browser::open(&server.url(""), server.dir()).await;
    browser.look(1280, 1000, false).await;
    browser.goto("/hooks").await;
    browser.sees("No hook is set up").await;
    browser.click("a.action[href='/hooks/new']").await;
    browser.wait("document.querySelector('form.deed')").await;
    browser.type_into("input[name=name]", "chat").await;
    browser.type_into("input[name=url]", &target.url()).await;
    browser.click("form.deed button").await;
    browser.wait("document.querySelector('main code')").await;
    browser.sees("whsec_").await;
    browser.click("main a[href^='/hooks/']").await;
    browser.wait("document.body.innerText.includes('Nothing has been sent yet.')").await;

    browser.click("form[action$='/test'] button").await;
    target.has_been_told(1).await;
    // A page is as things stood when it was asked for.
    let delivered =
        "[...document.querySelectorAll('.badge.in_tolerance')].some((badge) => badge.textContent == 'delivered')";
    reloads_until(&browser, delivered).await;
    browser.click("form[action$='/redeliver'] button").await;
    let told = target.has_been_told(2).await;
    assert_eq!(told[0].id(), told[1].id(), "the same message");
    reloads_until(&browser, &format!("{delivered} && document.querySelector('td.n').textContent == '2'")).await;

    browser.click("form[action$='/enabled'] button").await;
    browser.wait("document.querySelector('.badge.out_of_tolerance')").await;
    browser.sees("disabled").await;
    assert_eq!(browser.eval("document.querySelectorAll('form[action$=\"/test\"]').length").await, 0);
    browser.has_behaved().await;
}

/// Loads the page again until the expression is true.
async fn reloads_until(browser: &Browser, expression: &str) {
    let patience = Instant::now() + Duration::from_secs(120);
    while browser.eval(&format!("Boolean({expression})")).await != Value::Bool(true) {
        assert!(Instant::now() < patience, "never came true: {expression}\n{}", browser.text().await);
        tokio::time::sleep(Duration::from_millis(200)).await;
        let here = browser.eval("location.pathname").await;
        browser.goto(here.as_str().unwrap()).await;
    }
}

#[tokio::test]
async fn times_stand_in_the_viewers_zone_with_utc_beside_them() {
    if !chromium::is_installed() {
        return;
    }
    let server = Server::start().await;
    let mut record = document("paper.json");
    for month in 1..=4 {
        record["calibrated_at"] = format!("2026-0{month}-01T08:00:00Z").into();
        if month == 4 {
            let g = &mut record["gyros"][0]["g_pulse_per_s_g0"][0];
            *g = (1.01 * g.as_f64().unwrap()).into();
        }
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    }
    let browser = Browser::open(&server.url(""), server.dir()).await;
    browser.cdp("Emulation.setTimezoneOverride", json!({"timezoneId": "Asia/Shanghai"})).await;
    browser.goto("/gyros/LFG-0101").await;
    browser.wait("document.querySelector('#history')").await;
    let time = "document.querySelector('time[datetime=\"2026-03-01T08:00:00Z\"]')";
    assert_eq!(browser.eval(&format!("{time}.textContent")).await, "2026-03-01 16:00 UTC+8");
    assert_eq!(browser.eval(&format!("{time}.title")).await, "2026-03-01 08:00 UTC");
    // A day in a sentence says that it is one of UTC.
    browser.goto("/gyros/LFG-0101/diagnosis").await;
    let sentences = "document.querySelector('main').textContent.match(/[0-9]{4}-[0-9]{2}-[0-9]{2}(?! UTC| [0-9]{2}:)/)";
    assert_eq!(browser.eval(sentences).await, Value::Null);
    browser.goto("/gyros/LFG-0101").await;
    browser.wait("document.querySelector('#verdicts').textContent.includes('from 2026-01-01 UTC')").await;
    browser.has_behaved().await;
}

/// The day so many days before this one.
async fn days_ago(browser: &Browser, days: u32) -> String {
    let day = format!("new Date(Date.now() - {days} * 864e5).toISOString().slice(0, 10)");
    browser.eval(&day).await.as_str().unwrap().to_owned()
}

#[tokio::test]
async fn today_tells_what_the_pages_of_stations_and_gyros_tell() {
    let Some((_demo, browser)) = at_the_demo(1440, 900).await else { return };
    // What the station's page says of its window, whatever its gyros have read since.
    browser.goto("/stations").await;
    let window = browser.eval(
        "fetch('/v1/stations/ST-2').then((answer) => answer.json()).then(({D_I}) => D_I.windows.map((one) => [one.from.slice(0, 10), \
        one.until.slice(0, 10), one.gyros, one.imus, Math.round(1e4 * one.value)]))",
    );
    let window = window.await;
    let [from, until, gyros, imus, percent] = [0, 1, 2, 3, 4].map(|k| window[0][k].to_string().replace('"', ""));
    let block =
        "[...document.querySelectorAll('.block')].find((e) => e.textContent.includes('Several gyros')).innerText";
    let since = days_ago(&browser, 150).await;
    browser.goto(&format!("/?since={since}")).await;
    let told = browser.eval(block).await.as_str().unwrap().replace('\n', "");
    for there in [format!("{from} … {until}"), format!("{gyros} gyros of {imus} IMUs")] {
        assert!(told.contains(&there), "{there} is not in {told}");
    }
    assert!(told.contains(&format!("+{percent} ± ")) && told.contains("% of budget"), "{told}");
    // What began since the day that is asked for, with its own day.
    let since = days_ago(&browser, 14).await;
    browser.goto(&format!("/?since={since}")).await;
    let earlier = format!(
        "[...document.querySelector('.block').querySelectorAll('tr')].filter((e) => e.querySelector('time').dateTime < '{since}').map((e) => e.innerText)"
    );
    assert_eq!(browser.eval(&earlier).await, json!([]));
    browser.sees("LFG-0031").await;
    // When the gyro that ages reaches its budget, and until when to calibrate it.
    let row = "[...document.querySelectorAll('.block')].find((e) => e.textContent.includes('Will reach')).innerText";
    reloads_until(&browser, &format!("{row}.includes('Calibrate by')")).await;
    let today = browser.eval(row).await.as_str().unwrap().to_owned();
    browser.goto("/gyros/LFG-0014").await;
    reloads_until(&browser, "document.querySelector('.causes').innerText.includes('budget on')").await;
    let dates = browser
        .eval("document.querySelector('.causes').innerText.match(/budget on (\\S+) .* Calibrate it by (\\S+):/s)")
        .await;
    for date in [&dates[1], &dates[2]] {
        assert!(today.contains(date.as_str().unwrap()), "{date} is not in {today}");
    }
    let suggested = browser.eval("document.querySelector('.suggestion').innerText").await;
    assert!(suggested.as_str().unwrap().contains(dates[2].as_str().unwrap()), "{suggested}");
    // And the list of the fleet says the same day.
    browser.goto("/fleet?q=LFG-0014").await;
    let listed = browser.eval("document.querySelector('table.fleet tbody tr').innerText").await;
    assert!(listed.as_str().unwrap().contains(dates[1].as_str().unwrap()), "{dates} against {listed}");
    // By date, as the column shows them.
    browser.goto("/fleet?sort=eta").await;
    let dates = "[...document.querySelectorAll('table.fleet tbody tr')].map((e) => e.querySelector('.slope time')?.dateTime ?? '9')";
    let dates = browser.eval(dates).await;
    let dates: Vec<&str> = dates.as_array().unwrap().iter().map(|date| date.as_str().unwrap()).collect();
    assert!(dates[0] < "9" && dates.is_sorted(), "{dates:?}");
    // Beyond its budget, one date: the day on which it got there.
    browser.goto("/gyros/LFG-0004/report").await;
    let causes = browser.eval("document.querySelector('.causes').innerText").await;
    let causes = causes.as_str().unwrap();
    assert!(causes.contains("it reached its budget on") && !causes.contains("The rule trend"), "{causes}");
    // The page of the causes begins with them, that of a station with what it did.
    browser.goto("/gyros/LFG-0004/diagnosis").await;
    let first = browser.eval("document.querySelector('#D_I h2 + p').textContent").await;
    assert!(first.as_str().unwrap().starts_with("ageing (a steady slope) +0.01"), "{first}");
    browser.goto("/stations/ST-2").await;
    browser.sees(&format!("Off {from} … {until}, +{percent} ± ")).await;
    assert_eq!(browser.eval("document.querySelector('#D_I ol.flags').innerText.trim()").await, format!("{from} Off"));
    // An overdue gyro that was replaced stands for itself.
    browser.goto("/").await;
    browser.sees("no longer in IMU-09").await;
    // What acknowledging does, and what silencing does, are two things.
    browser.goto("/alerts/bulk?gyro=LFG-0004").await;
    for there in ["Acknowledge: Stops the repeats", "Silence: Nobody is told", "Days of silence"] {
        browser.sees(there).await;
    }
    // An alert whose figure is within its limit again says why it still fires.
    browser.goto("/alerts?serial=LFG-0008").await;
    let renewed = "[...document.querySelectorAll('table.alerts tbody tr')].filter((e) => e.textContent.includes('once the figure is well in tolerance')) \
        .map((e) => e.children[1].textContent)";
    assert_eq!(browser.eval(renewed).await, json!(["DS shift of level"]));
    // A list that goes on is printed as a part of it.
    browser.goto("/fleet").await;
    let printed =
        "[...document.querySelectorAll('.on-paper')].filter((e) => e.checkVisibility()).map((e) => e.innerText).join()";
    assert_eq!(browser.eval(printed).await, "");
    browser.on_paper().await;
    assert_eq!(browser.eval(printed).await, "Printed: this page of the list alone, 1 / 2");
    browser.has_behaved().await;
}

#[tokio::test]
async fn on_a_telephone_a_plot_and_what_is_done_with_alerts_are_at_hand() {
    let Some((_demo, browser)) = at_the_demo(390, 844).await else { return };
    for serial in ["LFG-0004", "LFG-0008", "LFG-0014", "LFG-0011", "LFG-0001"] {
        browser.goto(&format!("/gyros/{serial}")).await;
        let top = "document.querySelector('#history .picture').getBoundingClientRect().top + scrollY";
        let top = browser.eval(top).await.as_f64().unwrap();
        assert!(top < 844.0 - 120.0, "{serial}: the first plot begins at {top}");
    }
    browser.goto("/alerts").await;
    let there = "(({top, bottom}) => top >= 0 && bottom <= innerHeight + 1)(document.querySelector('#bulk button[value=acknowledge]').getBoundingClientRect())";
    browser.click("article.alerted input[type=checkbox]").await;
    browser.wait(there).await;
    // On a desk, on one line.
    browser.look(1440, 900, false).await;
    let line = "new Set([...document.querySelectorAll('#bulk button')].map((e) => e.getBoundingClientRect().top)).size";
    assert_eq!(browser.eval(line).await, 1);
    browser.has_behaved().await;
}

/// With the keyboard alone, from the start page on: what is pressed.
#[tokio::test]
async fn a_keyboard_leads_to_the_worst_gyro_and_its_first_alert_in_few_keys() {
    let Some((_demo, browser)) = at_the_demo(1280, 1000).await else { return };
    let focused = "document.activeElement.textContent";
    let to_worst = ["Tab", "Enter", "Tab", "Enter"];
    for page in ["/", "/fleet", "/alerts"] {
        browser.goto(page).await;
        for key in to_worst {
            browser.press(key).await;
        }
        assert_eq!(browser.eval(focused).await, "LFG-0008", "{page}");
        // On to the next line.
        browser.press("ArrowDown").await;
        assert_eq!(browser.eval(focused).await, "LFG-0004", "{page}");
    }
    browser.press("Enter").await;
    browser.wait("location.pathname == '/gyros/LFG-0004'").await;
    for key in to_worst {
        browser.press(key).await;
    }
    let mut tabs = 0;
    while browser
        .eval("document.activeElement.pathname || ''")
        .await
        .as_str()
        .is_none_or(|to| !to.starts_with("/alerts/"))
    {
        assert!(tabs < 4, "the first alert is {tabs} links behind the skip");
        browser.press("Tab").await;
        tabs += 1;
    }
    browser.press("Enter").await;
    browser.wait("location.pathname.startsWith('/alerts/')").await;
    browser.has_behaved().await;
}

/// What a quality engineer comes for, from the start page on: clicks and fields, as `docs/pages.md` has them.
const JOBS: [(&str, usize, usize); 11] = [
    ("Monday morning", 0, 0),
    ("the worst gyro, and what to do", 1, 0),
    ("a gyro that was repaired and moved", 0, 1),
    ("its report, to print", 1, 1),
    ("a CSV with a mistake in line 7", 1, 1),
    ("a diagnosis", 2, 0),
    ("two campaigns beside each other", 1, 1),
    ("three gyros of a batch beside one another", 4, 1),
    ("what got worse at ST-2 since June", 3, 2),
    ("a hook, and its test", 4, 2),
    ("every alert acknowledged", 3, 2),
];

#[tokio::test]
async fn the_jobs_of_a_quality_engineer_take_few_clicks_on_a_desk() {
    the_jobs(1440, 1).await;
}

#[tokio::test]
async fn the_jobs_take_no_more_on_a_telephone_with_a_processor_six_times_slower() {
    the_jobs(390, 6).await;
}

async fn the_jobs(width: u32, slower: u32) {
    let Some((demo, browser)) = at_the_demo(width, 900).await else { return };
    browser.cdp("Emulation.setCPUThrottlingRate", json!({"rate": slower})).await;
    let csv = std::fs::read_to_string(root().join("docs/examples/march.csv")).unwrap();
    assert!(csv.lines().nth(6).unwrap().starts_with("# gyros: G1 LFG-3001, G2 LFG-3002,"));
    let faulty = demo.dir.path().join("march.csv");
    std::fs::write(&faulty, csv.replace("G2 LFG-3002", "G2")).unwrap();
    browser.goto("/").await;
    for serial in ["LFG-0001", "LFG-0002", "LFG-0005"] {
        let body = "{method: 'PATCH', headers: {'content-type': 'application/json'}, body: '{\"batch\": \"B-17\"}'}";
        let done = format!("fetch('/v1/gyros/{serial}', {body}).then((answer) => answer.status)");
        assert_eq!(browser.eval(&done).await, 200);
    }
    // Diagnoses are made in the background, and the clock is looked at once a minute.
    browser.goto("/diagnoses").await;
    reloads_until(&browser, "document.querySelector(\"td a[href$='/diagnosis']\")").await;
    browser.goto("/alerts").await;
    reloads_until(&browser, "document.querySelector('.badge.overdue')").await;
    browser.goto("/").await;
    for (job, clicks, fields) in JOBS {
        browser.begin_job().await;
        let started = Instant::now();
        match job {
            "Monday morning" => {
                for there in ["New or worse since", "Still out of tolerance or drifting", "Overdue"] {
                    browser.sees(there).await;
                }
            }
            "the worst gyro, and what to do" => {
                browser.click("table.lines th a").await;
                browser.wait("document.querySelector('.suggestion')").await;
                browser.sees("LFG-0008").await;
            }
            "a gyro that was repaired and moved" => {
                browser.type_into("#find", "LFG-0011\n").await;
                browser.wait("document.querySelector('#history')").await;
                // The demo's days are counted back from today.
                let told = r"/repair \d{4}-\d\d-\d\d · moved \d{4}-\d\d-\d\d: IMU-04 G2 → IMU-09 G2/.test(document.body.innerText)";
                assert_eq!(browser.eval(told).await, true, "{}", browser.text().await);
            }
            "its report, to print" => {
                browser.type_into("#find", "LFG-0011\n").await;
                browser.wait("document.querySelector('#history')").await;
                browser.click("a.action[href$='/report']").await;
                browser.wait("document.querySelector('section.decide .signature')").await;
            }
            "a CSV with a mistake in line 7" => {
                browser.click("nav a[href='/import']").await;
                browser.type_into("input[type=file]", faulty.to_str().unwrap()).await;
                browser.wait("document.querySelector('tr.faulty')").await;
                browser.sees("line 7 (gyros)").await;
                let seen = "(({top, bottom}) => top >= 0 && bottom <= innerHeight)(document.querySelector('.fault').getBoundingClientRect())";
                browser.wait(seen).await;
            }
            "a diagnosis" => {
                browser.click("nav a[href='/diagnoses']").await;
                browser.wait("document.querySelector(\"td a[href$='/diagnosis']\")").await;
                browser.click("td a[href$='/diagnosis']").await;
                browser.wait("document.querySelector('ul.found') && document.querySelector('table.ladder')").await;
            }
            "two campaigns beside each other" => {
                browser.type_into("#find", "IMU-21\n").await;
                browser.wait("document.querySelector('form[action=\"/compare\"]')").await;
                browser.click("form[action='/compare'] button").await;
                browser.wait("document.querySelector('[data-label=\"(B - A)/σ\"]')").await;
            }
            "three gyros of a batch beside one another" => {
                browser.click("nav a[href='/fleet']").await;
                browser.click("details.filters summary").await;
                browser.type_into("input[name=batch]", "B-17\n").await;
                browser.wait("document.querySelectorAll('table.fleet tbody tr').length == 3").await;
                browser.click("[data-all]").await;
                browser.click("#selection button").await;
                browser.wait("document.querySelectorAll('svg.area').length == 3").await;
            }
            "what got worse at ST-2 since June" => {
                browser.click("nav a[href='/fleet']").await;
                browser.click("details.filters summary").await;
                browser.type_into("input[name=station]", "ST-2").await;
                browser.type_into("input[name=changed_since]", "06012026").await;
                browser.click("form.search button").await;
                browser.wait("location.search.includes('changed_since=2026-06-01')").await;
                browser.sees("LFG-0014").await;
            }
            "a hook, and its test" => {
                browser.click("nav a[href='/hooks']").await;
                browser.click("a.action[href='/hooks/new']").await;
                browser.type_into("input[name=name]", "chat").await;
                browser.type_into("input[name=url]", "http://127.0.0.1:9/").await;
                browser.click("form.deed button").await;
                browser.click("form[action$='/test'] button").await;
                browser.wait("document.body.innerText.includes('hook.test')").await;
            }
            _ => {
                browser.click("nav a[href='/alerts']").await;
                browser.click("[data-all]").await;
                browser.type_into("#bulk input[name=by]", "Li Wei").await;
                browser.type_into("#bulk input[name=reason]", "seen on Monday").await;
                browser.click("#bulk button[value=acknowledge]").await;
                browser.wait("document.querySelector('.done')").await;
                assert_eq!(browser.eval("document.querySelectorAll('.alerted').length").await, 0);
            }
        }
        eprintln!("{job}: {:.1} s", started.elapsed().as_secs_f64());
        assert_eq!(browser.took(), (clicks, fields), "{job}");
    }
    browser.has_behaved().await;
}

/// Names that a screen reader would miss, headings out of order, and text too faint to read (WCAG 2.2, 1.4.3: 4.5 to 1).
const FAULTS: &str = r#"(() => {
  const faults = [];
  const named = (e) => (e.getAttribute("aria-label") || e.textContent || e.title || "").trim();
  for (const e of document.querySelectorAll("a[href], button, svg[role=img]")) if (!named(e)) faults.push("no name: " + e.outerHTML.slice(0, 90));
  for (const e of document.querySelectorAll("input:not([type=hidden]), textarea:not([hidden]), select"))
    if (!e.labels.length && !e.getAttribute("aria-label")) faults.push("no label: " + e.outerHTML.slice(0, 90));
  for (const e of document.querySelectorAll("th")) if (!e.textContent.trim()) faults.push("an empty head: " + e.closest("tr").textContent.slice(0, 90));
  let level = 0;
  for (const e of document.querySelectorAll("h1, h2, h3")) {
    const own = Number(e.tagName[1]);
    if (own > level + 1) faults.push("heading out of order: " + e.textContent);
    level = own;
  }
  if (document.querySelectorAll("h1").length !== 1 || document.querySelectorAll("main").length !== 1) faults.push("not one h1 and one main");
  const channels = (text) => (text.match(/[\d.]+/g) || []).map(Number);
  const light = ([r, g, b]) => {
    const f = (c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    return 0.2126 * f(r) + 0.7152 * f(g) + 0.0722 * f(b);
  };
  const ground = (e) => {
    for (; e; e = e.parentElement) {
      const c = channels(getComputedStyle(e).backgroundColor);
      if (c.length === 3 || c[3] > 0) return c;
    }
    return [255, 255, 255];
  };
  const walker = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const e = walker.currentNode.parentElement;
    if (!walker.currentNode.textContent.trim() || !e.checkVisibility() || e.closest("svg, script")) continue;
    const [a, b] = [light(channels(getComputedStyle(e).color)), light(ground(e))].sort((x, y) => y - x);
    if ((a + 0.05) / (b + 0.05) < 4.5) faults.push("too faint: " + e.outerHTML.slice(0, 90));
  }
  for (const e of document.querySelectorAll(".picture, .picture circle, .picture text"))
    if (e.checkVisibility() && e.getBoundingClientRect().right > innerWidth + 1) faults.push("a plot wider than the view: " + e.outerHTML.slice(0, 90));
  if (document.documentElement.scrollWidth > innerWidth + 1) faults.push("wider than the view: " + document.documentElement.scrollWidth);
  return [...new Set(faults)];
})()"#;

/// On a screen no table is cut off, no name torn apart, and nothing lies over the figures beside an axis.
const CUT: &str = r#"(() => {
  const faults = [];
  for (const e of document.querySelectorAll(".scroll"))
    if (e.scrollWidth > e.clientWidth + 1) faults.push(`a table ${e.scrollWidth} wide in ${e.clientWidth}: ${e.innerText.slice(0, 60)}`);
  for (const e of document.querySelectorAll(".id"))
    if (e.checkVisibility() && e.offsetHeight > 1.9 * parseFloat(getComputedStyle(e).lineHeight)) faults.push("torn apart: " + e.textContent);
  for (const axis of document.querySelectorAll("svg.axis")) {
    const figures = [...axis.querySelectorAll("text")].map((e) => [e.textContent, e.getBoundingClientRect()]);
    figures.forEach(([one, a], k) => figures.slice(0, k).forEach(([other, b]) => {
      if (a.top + 2 < b.bottom - 2 && b.top + 2 < a.bottom - 2) faults.push(`${one} lies on ${other}`);
    }));
    for (const [one, a] of figures) if (a.left < axis.getBoundingClientRect().left - 1) faults.push(`${one} is cut off`);
  }
  return faults;
})()"#;

/// On a telephone a table of figures is a list: every figure has its name beside it.
const NAMELESS: &str = r#"[...document.querySelectorAll("table.cards tbody td:is(.n, .nowrap)")]
  .filter((e) => e.checkVisibility() && /\d/.test(e.textContent) && !e.dataset.label && !e.querySelector(".label")).map((e) => "no name: " + e.outerHTML.slice(0, 120))"#;

/// English left on a Chinese page: words that are neither a name with digits or capitals, nor a unit, nor what
/// somebody wrote.
const ENGLISH: &str = r#"(() => {
  const allowed = new Set(["deg", "ppm", "arcsec", "pulse", "rms", "gyrowatch", "English", "standard-webhooks", "alertmanager",
    "alertmanager-webhook", "cloudevents", "Authorization", "Bearer", "import", "dwells", "https"]);
  const found = new Set();
  const look = (text) => {
    for (const word of text.match(/[A-Za-z0-9_./:'’-]+/g) || []) {
      const plain = word.replace(/^[./:'’-]+|[./:'’-]+$/g, "");
      if (/^[A-Za-z][a-z'’-]{2,}$/.test(plain) && !allowed.has(plain)) found.add(`${plain}: ${text.trim().slice(0, 120)}`);
    }
  };
  const apart = "[translate=no], code, script, style, textarea, [lang]:not([lang=zh])";
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) if (!walker.currentNode.parentElement.closest(apart)) look(walker.currentNode.textContent);
  for (const name of ["title", "aria-label", "placeholder"])
    for (const e of document.querySelectorAll(`[${name}]`)) if (!e.closest(apart)) look(e.getAttribute(name));
  look(document.title);
  return [...found];
})()"#;

#[tokio::test]
async fn every_page_is_fit_to_be_seen_on_a_screen_in_english() {
    every_page_is_fit_to_be_seen(1280, "en").await;
}

#[tokio::test]
async fn every_page_is_fit_to_be_seen_on_a_screen_in_chinese() {
    every_page_is_fit_to_be_seen(1280, "zh").await;
}

#[tokio::test]
async fn every_page_is_fit_to_be_seen_on_a_telephone_in_english() {
    every_page_is_fit_to_be_seen(390, "en").await;
}

#[tokio::test]
async fn every_page_is_fit_to_be_seen_on_a_telephone_in_chinese() {
    every_page_is_fit_to_be_seen(390, "zh").await;
}

/// Where the pictures are put.
fn pictures() -> PathBuf {
    let pictures = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("../screenshots");
    std::fs::create_dir_all(&pictures).unwrap();
    pictures
}

/// A hook with something to tell that nobody hears: its identifier.
async fn set_up_hook(browser: &Browser) -> String {
    let hook = "fetch('/v1/hooks', {method: 'POST', headers: {'content-type': 'application/json'}, \
        body: '{\"kind\": \"cloudevents\", \"name\": \"值班台\", \"url\": \"http://127.0.0.1:9/\"}'}).then((answer) => answer.json())";
    let id = browser.eval(hook).await["id"].as_str().unwrap().to_owned();
    browser.eval(&format!("fetch('/v1/hooks/{id}/test', {{method: 'POST'}}).then((answer) => answer.status)")).await;
    id
}

/// Light and dark.
async fn every_page_is_fit_to_be_seen(width: u32, language: &str) {
    if !chromium::is_installed() {
        return;
    }
    let demo = Demo::start();
    let pictures = pictures();
    let browser = Browser::open(&demo.base, demo.dir.path()).await;
    // What it judges is the same on a telephone and in the other language.
    let axe = chromium::axe().filter(|_| width > 1000 && language == "en");
    if let Some(source) = &axe {
        browser.learn_axe(source).await;
    }
    browser.goto("/imus/IMU-21").await;
    let newest = "[...document.querySelectorAll(\"td.words a[href$='/diagnosis']\")][1].pathname";
    let diagnosis = browser.eval(newest).await.as_str().unwrap().to_owned();
    let campaign = diagnosis.strip_suffix("/diagnosis").unwrap().to_owned();
    let chosen = "'/compare?' + [...document.querySelectorAll('input[name=campaign]')].slice(0, 2) \
        .map((e) => 'campaign=' + e.value).join('&')";
    let compared = browser.eval(chosen).await.as_str().unwrap().to_owned();
    browser.goto("/gyros/LFG-0004").await;
    let link = |start: &str| format!("document.querySelector(\"td a[href^='{start}']\").pathname");
    let record = browser.eval(&link("/records/")).await;
    let acknowledge = browser.eval(&link("/alerts/")).await;
    let alert = acknowledge.as_str().unwrap().trim_end_matches("/acknowledge").to_owned();
    let void = format!("{}/void", record.as_str().unwrap());
    let hook = format!("/hooks/{}", set_up_hook(&browser).await);
    let delete = format!("{hook}/delete");
    let pages = [
        ("today", "/?since=2026-01-01"),
        ("fleet", "/fleet"),
        ("fleet-imu", "/fleet?view=imu"),
        ("setup", "/setup"),
        ("alerts-bulk", "/alerts/bulk?gyro=LFG-0004"),
        ("alert", &alert),
        ("gyro", "/gyros/LFG-0011"),
        ("drifting", "/gyros/LFG-0004"),
        ("gyro-diagnosis", "/gyros/LFG-0004/diagnosis"),
        ("bench", "/gyros/PAPER-T5-G1?method=bench"),
        ("imu", "/imus/IMU-21"),
        ("record", record.as_str().unwrap()),
        ("campaign", &campaign),
        ("diagnosis", &diagnosis),
        ("diagnoses", "/diagnoses"),
        ("stations", "/stations"),
        ("station", "/stations/ST-2"),
        ("import", "/import"),
        ("alerts", "/alerts"),
        ("void", &void),
        ("acknowledge", acknowledge.as_str().unwrap()),
        ("event", "/gyros/LFG-0004/events/new"),
        ("decision", "/gyros/LFG-0004/events/new?event=decision_remove"),
        ("baseline", "/gyros/LFG-0004/events/new?event=baseline"),
        ("sign-in", "/sign-in"),
        ("hooks", "/hooks"),
        ("hook", &hook),
        ("hook-new", "/hooks/new"),
        ("hook-delete", &delete),
        ("compare-gyros", "/compare?gyro=LFG-0004&gyro=LFG-0005&gyro=LFG-0006"),
        ("compare-campaigns", &compared),
        ("report-gyro", "/gyros/LFG-0004/report"),
        ("report-imu", "/imus/IMU-21/report"),
        ("api", "/docs"),
        ("api-records", "/docs/records"),
        ("book", if language == "zh" { "/book/zh/adopt-predict-compare" } else { "/book/tutorials/own-csv" }),
    ];
    let mut wrong = Vec::new();
    for dark in [false, true] {
        browser.look(width, 900, dark).await;
        browser.goto(&format!("/preference?language={language}")).await;
        for (name, path) in pages {
            browser.goto(path).await;
            browser.wait("!document.querySelector('#waiting')").await;
            let mut faults = vec![browser.eval(FAULTS).await];
            // A telephone shows a page that is too wide at a smaller scale: its own view is no measure.
            let wide = browser.eval("document.documentElement.scrollWidth").await;
            if wide.as_u64().is_none_or(|wide| wide > u64::from(width)) {
                wrong.push(format!("{path} in {language} is {wide} wide, the view {width}"));
            }
            faults.push(browser.eval(if width > 1000 { CUT } else { NAMELESS }).await);
            if axe.is_some() {
                faults.push(browser.grave_faults().await);
            }
            if language == "zh" {
                faults.push(browser.eval(ENGLISH).await);
            }
            let seen = format!("{path} in {language}, dark {dark}, {width} pixels wide");
            wrong.extend(
                faults.iter().flat_map(|list| list.as_array().unwrap()).map(|fault| format!("{seen}: {fault}")),
            );
            let theme = if dark { "dark" } else { "light" };
            browser.picture(&pictures.join(format!("{name}-{language}-{theme}-{width}.png"))).await;
        }
        assert_eq!(browser.eval("document.documentElement.lang").await, language);
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    browser.has_behaved().await;
}

#[tokio::test]
async fn a_report_prints_on_a_few_sheets_with_its_plots_and_without_what_is_for_clicking() {
    if !chromium::is_installed() {
        return;
    }
    let demo = Demo::start();
    let browser = Browser::open(&demo.base, demo.dir.path()).await;
    let printed = [
        ("gyro", "/gyros/LFG-0004/report", "en"),
        ("gyro", "/gyros/LFG-0004/report", "zh"),
        ("imu", "/imus/IMU-02/report", "en"),
        ("page", "/gyros/LFG-0011", "en"),
    ];
    for (name, path, language) in printed {
        // The width of A4 between its margins, in CSS pixels. From the dark theme: on paper it is light.
        browser.look(680, 900, true).await;
        browser.goto(&format!("/preference?language={language}&theme=dark&back={path}")).await;
        let pdf = browser.pdf().await;
        std::fs::write(pictures().join(format!("report-{name}-{language}.pdf")), &pdf).unwrap();
        let sheets = pdf.windows(11).filter(|bytes| *bytes == b"/Type /Page").count() - 1;
        assert!(pdf.starts_with(b"%PDF") && (2..=14).contains(&sheets), "{sheets} sheets");
        browser.on_paper().await;
        if name == "gyro" {
            // 297 mm less the margins of 14 and 16, at 96 pixels an inch.
            let decide = browser.eval("document.querySelector('section.decide').getBoundingClientRect().height").await;
            assert!(decide.as_f64().unwrap() < 1009.0, "the decision sheet in {language} is {decide} high");
            let parts = ".facts, table.loads, .picture, .boxes, .signature, table.small";
            let parts = format!(
                "[...document.querySelectorAll('section.decide :is({parts})')].filter((e) => e.checkVisibility()).map((e) => e.className)"
            );
            let parts = browser.eval(&parts).await;
            assert_eq!(
                parts,
                json!(["facts", "loads", "picture", "picture", "small", "small", "boxes", "signature", "signature"])
            );
        }
        // The newest points are on paper.
        let newest = "[...document.querySelectorAll('svg.area')].filter((area) => area.checkVisibility() \
            && area.querySelector('g.record')).map((area) => area.querySelector('g.record').lastElementChild)";
        let there = format!(
            "{newest}.length >= 2 && {newest}.every((e) => e.getBoundingClientRect().right < innerWidth && e.checkVisibility())"
        );
        assert_eq!(browser.eval(&there).await, true, "{path}");
        if name != "page" {
            let foot = "[...document.querySelectorAll('head style')].map((e) => e.textContent).join()";
            let foot = browser.eval(foot).await;
            assert!(foot.as_str().is_some_and(|foot| foot.contains("counter(page)")), "{path}: {foot}");
        }
        let shown = "[...document.querySelectorAll('header.bar, form, nav, .actions')].filter((e) => e.checkVisibility()).length";
        assert_eq!(browser.eval(shown).await, 0);
        assert_eq!(browser.eval("getComputedStyle(document.body).backgroundColor").await, "rgb(255, 255, 255)");
        let faint = format!("{FAULTS}.filter((fault) => fault.startsWith('too faint'))");
        assert_eq!(browser.eval(&faint).await, json!([]), "{path} in {language}");
        let overlaid = "[...document.querySelectorAll('table.judged tr')].filter((e) => e.checkVisibility()).flatMap((row) => { \
            const cells = [...row.cells].filter((e) => e.textContent.trim() && getComputedStyle(e).display !== 'contents').map((e) => { \
                const range = document.createRange(); range.selectNodeContents(e); return range.getBoundingClientRect(); }); \
            return cells.slice(1).filter((b, k) => cells[k].right > b.left && cells[k].top < b.bottom && b.top < cells[k].bottom).map(() => row.innerText); })";
        assert_eq!(browser.eval(overlaid).await, json!([]), "{path}: verdicts lie on one another");
        let cut = "[...document.querySelectorAll('.scroll')].filter((e) => e.scrollWidth > document.documentElement.clientWidth).map((e) => e.textContent.slice(0, 80)).join('; ')";
        assert_eq!(browser.eval(cut).await, "", "tables wider than the sheet");
        browser.picture(&pictures().join(format!("paper-{name}-{language}.png"))).await;
    }
    browser.has_behaved().await;
}

#[tokio::test]
async fn a_command_prints_a_report_and_refuses_what_is_none() {
    if !chromium::is_installed() || !support::required("curl") {
        return;
    }
    let demo = Demo::start();
    let file = demo.dir.path().join("report.pdf");
    let print = |address: String| {
        let mut command = Command::new(root().join("scripts/print_report"));
        command.arg(address).arg(&file).env("CHROMIUM", "chromium --no-sandbox").env("GYROWATCH_LANGUAGE", "zh");
        command.output().unwrap()
    };
    let done = print(format!("{}/gyros/LFG-0004/report", demo.base));
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let pdf = std::fs::read(&file).unwrap();
    std::fs::write(pictures().join("printed-report.pdf"), &pdf).unwrap();
    let sheets = pdf.windows(11).filter(|bytes| *bytes == b"/Type /Page").count() - 1;
    assert!(pdf.starts_with(b"%PDF") && (2..=8).contains(&sheets), "{sheets} sheets");
    for none in ["/gyros/LFG-0004", "/gyros/NOBODY/report"] {
        let refused = print(format!("{}{none}", demo.base));
        assert!(!refused.status.success() && !refused.stderr.is_empty(), "{none}");
    }
}
