//! Alerts by e-mail: what a mail server receives, and what becomes of mail that it refuses.

use std::sync::Mutex;

use gyrowatch::core::time::UtcMicros;
use gyrowatch::system::Clock;
use gyrowatch::wire::time;
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::net::{TcpListener, TcpStream};

use crate::prelude::*;

/// A mail server that keeps what it is handed; the first so many messages it refuses.
struct MailServer {
    address: String,
    mails: Arc<Mutex<Vec<String>>>,
    refused: Arc<Mutex<usize>>,
}

impl MailServer {
    async fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let (mails, refused) = (Arc::new(Mutex::new(Vec::new())), Arc::new(Mutex::new(0)));
        let kept = (mails.clone(), refused.clone());
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                tokio::spawn(serve(stream, kept.0.clone(), kept.1.clone()));
            }
        });
        Self { address, mails, refused }
    }

    /// Waits for so many messages.
    async fn received(&self, count: usize) -> Vec<String> {
        let began = Instant::now();
        loop {
            let mails = self.mails.lock().unwrap().clone();
            if mails.len() >= count {
                return mails;
            }
            assert!(began.elapsed() < Duration::from_secs(20), "{} of {count} mails: {mails:?}", mails.len());
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }
}

/// RFC 5321, as much as a client needs: each mail is kept as its envelope and its content.
async fn serve(stream: TcpStream, mails: Arc<Mutex<Vec<String>>>, refused: Arc<Mutex<usize>>) {
    let (read, mut write) = stream.into_split();
    let mut lines = BufReader::new(read).lines();
    write.write_all(b"220 mail\r\n").await.unwrap();
    let mut mail = String::new();
    while let Ok(Some(line)) = lines.next_line().await {
        let verb = line.split(' ').next().unwrap().to_ascii_uppercase();
        let answer = match verb.as_str() {
            "EHLO" => "250 mail",
            "DATA" => {
                write.write_all(b"354 go on\r\n").await.unwrap();
                while let Ok(Some(line)) = lines.next_line().await {
                    if line == "." {
                        break;
                    }
                    mail.push_str(&line);
                    mail.push('\n');
                }
                let left = { std::mem::replace(&mut *refused.lock().unwrap(), 0) };
                if left > 0 {
                    *refused.lock().unwrap() = left - 1;
                    mail.clear();
                    "451 not now"
                } else {
                    mails.lock().unwrap().push(std::mem::take(&mut mail));
                    "250 taken"
                }
            }
            "RCPT" if line.contains("gone@") => "550 no such user",
            "RCPT" if line.contains("new@") => "450 greylisted",
            "RCPT" if line.contains("slow@") => {
                tokio::time::sleep(Duration::from_secs(60)).await;
                "250 ok"
            }
            "RSET" => {
                mail.clear();
                "250 ok"
            }
            "QUIT" => "221 bye",
            _ => {
                mail.push_str(&line);
                mail.push('\n');
                "250 ok"
            }
        };
        if write.write_all(format!("{answer}\r\n").as_bytes()).await.is_err() {
            return;
        }
    }
}

async fn with(mail: &MailServer) -> Server {
    let url = format!("smtp://{}", mail.address);
    Server::start_with(&[
        ("GYROWATCH_HOOKS__SMTP_URL", &url),
        ("GYROWATCH_HOOKS__MAIL_FROM", "gyrowatch@lab.example"),
        ("GYROWATCH_HOOKS__RETRY_WAITS_S", "0.2,0.2"),
        ("GYROWATCH_HOOKS__CONNECT_TIMEOUT_S", "1"),
        ("GYROWATCH_HOOKS__ATTEMPT_TIMEOUT_S", "2"),
        ("GYROWATCH_HOOKS__EXTERNAL_URL", "https://gyros.example"),
    ])
    .await
}

/// Campaigns of this month; D_I of one gyro is far off in the last two.
async fn violates(server: &Server) {
    let now = Clock::System.now();
    for number in 0..8_i64 {
        let mut record = paper_record(0, 0);
        record["calibrated_at"] = time::format(UtcMicros(now.0 - (8 - number) * 72 * 3_600_000_000)).into();
        let g = &mut record["gyros"][0]["g_pulse_per_s_g0"][0];
        let factor = if number > 5 { 1.5 } else { 1.0 + 1e-7 * number as f64 };
        *g = Value::from(g.as_f64().unwrap() * factor);
        server.post_json("/v1/records", &record).await.created();
    }
}

#[tokio::test]
async fn an_alert_is_mailed_to_every_recipient_after_the_server_refused_it_once() {
    let mail = MailServer::start().await;
    let server = with(&mail).await;
    let hook = json!({ "kind": "email", "url": "mailto:wei.li@lab.example,weber@lab.example" });
    let made = server.post_json("/v1/hooks", &hook).await.created();
    let id = made["id"].as_str().unwrap().to_owned();
    let test = server.post_json(&format!("/v1/hooks/{id}/test"), &json!({})).await;
    assert!(test.status < 300, "{}", test.text());
    let test = &mail.received(2).await[0];
    assert!(test.contains("Subject: Test of the hook email"), "{test}");

    // The first recipient's mail is refused for now: it is sent again.
    *mail.refused.lock().unwrap() = 1;
    violates(&server).await;
    let mails = mail.received(5).await;
    for recipient in ["RCPT TO:<wei.li@lab.example>", "RCPT TO:<weber@lab.example>"] {
        let alert = mails[2..].iter().find(|mail| mail.contains(recipient)).unwrap();
        for part in ["MAIL FROM:<gyrowatch@lab.example>", "Message-ID: <", "https://gyros.example/gyros/", "D_I"] {
            assert!(alert.contains(part), "{part} in {alert}");
        }
    }
    let deliveries = server.get(&format!("/v1/hooks/{id}/deliveries")).await.json();
    let states: Vec<&str> =
        deliveries["deliveries"].as_array().unwrap().iter().map(|one| one["state"].as_str().unwrap()).collect();
    assert!(states.contains(&"delivered"), "{deliveries}");
}

#[tokio::test]
async fn a_recipient_whom_the_server_does_not_know_keeps_the_mail_from_nobody_else() {
    let mail = MailServer::start().await;
    let server = with(&mail).await;
    let hook = async |url: &str| {
        let made = server.post_json("/v1/hooks", &json!({ "kind": "email", "url": url, "name": url })).await.created();
        made["id"].as_str().unwrap().to_owned()
    };
    let ended = async |id: &str| {
        assert!(server.post_json(&format!("/v1/hooks/{id}/test"), &json!({})).await.status < 300);
        let began = Instant::now();
        loop {
            let listed = server.get(&format!("/v1/hooks/{id}/deliveries")).await.json();
            let one = listed["deliveries"][0].clone();
            if ["delivered", "dead"].contains(&one["state"].as_str().unwrap_or_default()) {
                return one;
            }
            assert!(began.elapsed() < Duration::from_secs(20), "{listed}");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    let both = hook("mailto:gone@lab.example,weber@lab.example").await;
    assert_eq!(ended(&both).await["state"], "delivered");
    assert!(mail.received(1).await[0].contains("RCPT TO:<weber@lab.example>"));
    let alone = hook("mailto:gone@lab.example").await;
    let dead = ended(&alone).await;
    assert!(dead["state"] == "dead" && dead.to_string().contains("gone@lab.example"), "{dead}");
    assert_eq!(dead["attempts"].as_array().unwrap().len(), 1, "no other answer can come: {dead}");
}

#[tokio::test]
async fn who_has_taken_a_mail_is_not_sent_it_again_while_another_is_put_off_or_slow() {
    let mail = MailServer::start().await;
    let server = with(&mail).await;
    let attempts = async |url: &str| {
        let made = server.post_json("/v1/hooks", &json!({ "kind": "email", "url": url })).await;
        let id = made.json()["id"].as_str().unwrap().to_owned();
        let audit = server.get("/v1/audit").await.text();
        assert!(audit.contains(url), "{audit}");
        assert!(server.post_json(&format!("/v1/hooks/{id}/test"), &json!({})).await.status < 300);
        let began = Instant::now();
        loop {
            let one = server.get(&format!("/v1/hooks/{id}/deliveries")).await.json()["deliveries"][0].clone();
            if one["state"] == "dead" {
                break one["attempts"].as_array().unwrap().clone();
            }
            assert!(began.elapsed() < Duration::from_secs(30), "{one}");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    let put_off = attempts("mailto:new@lab.example,slow@lab.example,weber@lab.example").await;
    assert_eq!(put_off.len(), 3);
    assert_eq!(put_off[0]["status"], 450, "that is of the message, the server is there: {}", put_off[0]);
    let mails = mail.received(1).await;
    assert!(mails.len() == 1 && mails[0].contains("RCPT TO:<weber@lab.example>"), "{mails:?}");
    // What was said to another is no answer to the one who was not served.
    let slow = attempts("mailto:slow@lab.example,weber@lab.example").await;
    assert!(slow.len() == 3 && slow[0]["status"].is_null(), "{slow:?}");
    assert_eq!(mail.received(2).await.len(), 2);
}

#[tokio::test]
async fn a_target_of_the_wrong_kind_is_refused() {
    let mail = MailServer::start().await;
    let server = with(&mail).await;
    for (kind, url) in [
        ("email", "https://lab.example/"),
        ("email", "mailto:nobody"),
        ("standard-webhooks", "mailto:weber@lab.example"),
    ] {
        let answer = server.post_json("/v1/hooks", &json!({ "kind": kind, "url": url })).await;
        assert_eq!(answer.status, 422, "{kind} {url}: {}", answer.text());
        assert_eq!(answer.json()["errors"][0]["pointer"], "/url");
    }
    let made = server.post_json("/v1/hooks", &json!({ "kind": "email", "url": "mailto:weber@lab.example" })).await;
    let path = format!("/v1/hooks/{}", made.json()["id"].as_str().unwrap());
    let change = json!({ "url": "http://127.0.0.1:9/" }).to_string();
    server.call("PATCH", &path, &[("content-type", "application/json")], change).await.has(422);

    let without = Server::start().await;
    let answer = without.post_json("/v1/hooks", &json!({ "kind": "email", "url": "mailto:weber@lab.example" })).await;
    assert_eq!(answer.status, 422);
    assert!(answer.text().contains("hooks.smtp_url"), "{}", answer.text());
}
