//! Whom the workbench refuses: other sites, other names, forms, paths out of the folder, and anything that is not a
//! question.

use super::server::{Bench, imported};
use serde_json::{Value, json};
use softdock_tests::process::{scratch, softdock, words};
use std::fs;

#[test]
fn other_sites_get_nothing() {
    let folder = imported("workbench_guard", "guide_coulomb");
    let bench = Bench::start(&folder);
    let (host, token) = (bench.host(), bench.token.clone());
    let get = |headers: &str| {
        bench
            .send(&format!(
                "GET /api/session HTTP/1.1\r\n{headers}connection: close\r\n\r\n"
            ))
            .status
    };
    assert_eq!(get(&format!("host: {host}\r\n")), 200);
    assert_eq!(
        get(&format!("host: {host}\r\nsec-fetch-site: none\r\n")),
        200
    );
    assert_eq!(
        get(&format!("host: {host}\r\norigin: http://{host}\r\n")),
        200
    );
    assert_eq!(get("host: evil.example\r\n"), 421);
    assert_eq!(get(&format!("host: evil.example:{}\r\n", bench.port)), 421);
    assert_eq!(
        get(&format!("host: {host}\r\norigin: http://evil.example\r\n")),
        403
    );
    assert_eq!(
        get(&format!("host: {host}\r\nsec-fetch-site: cross-site\r\n")),
        403
    );
    assert_eq!(
        get(&format!("host: {host}\r\nsec-fetch-site: same-site\r\n")),
        403
    );

    let pair = json!({"model": "model.toml", "recording": "test.mcap"}).to_string();
    let post = |headers: &str| {
        let request = format!(
            "POST /api/compare HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\ncontent-length: {}\r\n{headers}\r\n{pair}",
            pair.len()
        );
        bench.send(&request).status
    };
    let json = "content-type: application/json\r\n";
    assert_eq!(post(&format!("{json}x-softdock: {token}\r\n")), 200);
    assert_eq!(post(json), 403);
    assert_eq!(post(&format!("{json}x-softdock: 0\r\n")), 403);
    assert_eq!(post(&format!("x-softdock: {token}\r\n")), 415);
    assert_eq!(
        post(&format!(
            "content-type: application/x-www-form-urlencoded\r\nx-softdock: {token}\r\n"
        )),
        415
    );
}

#[test]
fn no_path_leads_out_of_the_folder() {
    let folder = imported("workbench_paths", "guide_coulomb");
    let secret = folder.parent().unwrap().join("secret.toml");
    fs::write(&secret, "[actuator]\nlag_s = 0.123\n").unwrap();
    fs::copy(
        folder.join("test.mcap"),
        folder.parent().unwrap().join("secret.mcap"),
    )
    .unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(folder.parent().unwrap(), folder.join("link")).unwrap();
    let bench = Bench::start(&folder);
    let absolute = secret.display().to_string().replace('/', "%2F");
    for id in [
        "..%2Fsecret.toml",
        "%2e%2e%2fsecret.toml",
        "..%5Csecret.toml",
        ".%2F..%2Fsecret.toml",
        "link%2Fsecret.toml",
        "%252e%252e%252fsecret.toml",
        "..%2F..%2Fetc%2Fpasswd",
        "model.toml%2F..%2F..%2Fsecret.toml",
        "model.toml%00",
        "..%c0%afsecret.toml",
        "....%2F%2Fsecret.toml",
        &absolute,
    ] {
        for path in [
            format!("models/{id}"),
            format!("recordings/{}/channels", id.replace("toml", "mcap")),
        ] {
            let answer = bench.get(&format!("/api/{path}"));
            assert!(
                matches!(answer.status, 400 | 404),
                "{path}: {}",
                answer.status
            );
        }
    }
    for path in [
        "/../Cargo.toml",
        "/assets/../server.rs",
        "/assets/..%2Fserver.rs",
        "/assets/%2e%2e/lib.rs",
    ] {
        assert_eq!(bench.get(path).status, 404, "{path}");
    }
    let listed = String::from_utf8(bench.get("/api/models").body).unwrap();
    assert!(!listed.contains("secret"), "{listed}");
    let out = json!({"model": "../secret.toml", "recording": "test.mcap"});
    assert_eq!(bench.post("/api/compare", &out).status, 400);
}

#[test]
fn anything_that_is_no_question_is_refused_and_the_next_one_answered() {
    let folder = imported("workbench_soup", "guide_coulomb");
    fs::write(folder.join("broken.mcap"), "no recording").unwrap();
    fs::write(folder.join("broken.toml"), "[actuator]\n[noise]\nlag = 1\n").unwrap();
    let bench = Bench::start(&folder);
    let large = json!({"model": "m".repeat(100_000), "recording": ""});
    assert_eq!(bench.post("/api/compare", &large).status, 413);
    for body in [
        json!(null),
        json!([]),
        json!({}),
        json!({"model": 1}),
        json!({"kind": "run"}),
        json!("\u{0}"),
    ] {
        for path in [
            "compare",
            "check",
            "jobs",
            "models/model.toml/effects",
            "models/model.toml/effects/x/remove",
        ] {
            let answer = bench.post(&format!("/api/{path}"), &body);
            assert!(
                (400..500).contains(&answer.status),
                "{path} {body}: {}",
                answer.status
            );
            assert!(answer.json()["error"].is_string());
        }
    }
    for (path, expected) in [
        ("/api/nothing", 404),
        ("/api/models/broken.toml", 422),
        ("/api/recordings/broken.mcap/channels", 422),
        ("/api/recordings/test.mcap/series?c=nothing", 404),
        ("/api/recordings/test.mcap/series", 400),
        (
            "/api/prediction?recording=test.mcap&model=model.toml&channel=wrench&axis=q",
            400,
        ),
        ("/api/jobs/77/events", 404),
        ("/api/jobs/77/result", 404),
        ("/api/jobs/x/result", 400),
        ("/api/effects/nothing", 404),
    ] {
        assert_eq!(bench.get(path).status, expected, "{path}");
    }
    let broken = |list: Value| {
        list.as_array()
            .unwrap()
            .iter()
            .filter(|one| one["error"].is_string())
            .count()
    };
    assert_eq!(broken(bench.get("/api/recordings").json()), 1);
    assert_eq!(broken(bench.get("/api/models").json()), 1);
}

/// Beyond this computer nothing is answered without the token, and the page takes it from its address.
#[test]
fn who_asks_over_the_network_has_to_know_the_token() {
    let folder = scratch("workbench_network");
    let secret = "0123456789abcdef";
    let alone = softdock(&folder, &["workbench", "--listen", "127.0.0.1"]);
    assert!(
        alone.code != Some(0) && alone.stderr.contains("--token"),
        "{}",
        alone.stderr
    );
    let short = softdock(&folder, &words("workbench --listen 127.0.0.1 --token abc"));
    assert!(
        short.stderr.contains("at least 16 letters"),
        "{}",
        short.stderr
    );

    let bench = Bench::listening(&folder, &["--listen", "127.0.0.1", "--token", secret]);
    let status = |path: &str, headers: &str| {
        let request = format!(
            "GET {path} HTTP/1.1\r\nhost: laboratory:{}\r\nconnection: close\r\n{headers}\r\n",
            bench.port
        );
        bench.send(&request).status
    };
    for path in [
        "/",
        "/api/session",
        "/assets/app.js",
        "/?token=0123456789abcdee",
    ] {
        assert_eq!(status(path, ""), 401, "{path}");
    }
    assert_eq!(status(&format!("/api/session?token={secret}"), ""), 401);
    assert_eq!(status(&format!("/?token={secret}"), ""), 303);
    let cookie = format!("cookie: softdock_{}={secret}\r\n", bench.port);
    let bearer = format!("authorization: Bearer {secret}\r\n");
    for known in [&cookie, &bearer] {
        assert_eq!(status("/api/session", known), 200, "{known}");
        assert_eq!(
            status("/", &format!("{known}origin: http://evil.example\r\n")),
            403
        );
    }
}
