//! What is refused, and what is no board.

use crate::board_link::support::{cal_with_effects, on, read, turned};
use crate::common::{folder, ironout, text, write};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpListener;

#[test]
fn what_cannot_be_sent_is_refused_before_anything_is() {
    let here = folder("link-refused");
    let board = turned(66);
    let cal = cal_with_effects(&here);
    let change = |name: &str, change: &dyn Fn(&mut Value)| {
        let mut value = read(&cal);
        change(&mut value);
        write(&here, name, value.to_string())
    };
    let five = change("five.json", &|value| {
        let one = value["effects"][0].clone();
        value["effects"] = Value::Array(vec![one; 5]);
    });
    let unknown = change("unknown.json", &|value| value["effects"][0]["id"] = json!("servo"));
    let rotated = change("rotated.json", &|value| {
        value["effects"][0]["id"] = json!("gain:temp_c");
        value["reading"] = json!({"ut_per_count": null, "rotate": ["yaw90"]});
    });
    let scaled = change("scaled.json", &|value| {
        value["reading"] = json!({"ut_per_count": [0.5, 0.5, 0.5], "rotate": []});
    });
    for (file, words) in [
        (&five, "more than 4 effects"),
        (&unknown, "there is no effect servo"),
        (&rotated, "cannot be rotated back"),
        (&scaled, "0.5,0.5,0.5 µT per count"),
    ] {
        let run = on(&board, &["send", text(file), "--json"]);
        let message = run.error()["message"].to_string();
        assert!(message.contains(words), "{words}: {message}");
    }
    let shown = board.with(|bench| bench.board.command("cal show").pop().unwrap_or_default());
    assert!(shown.expect("it runs").starts_with("err state"), "nothing was sent");
    // A board that collects says no, and goes on collecting.
    board.with(|bench| bench.board.command("cal start"));
    let run = on(&board, &["send", text(&cal)]);
    assert!(run.status == 1 && run.said().contains("samples are being collected"), "{}", run.stderr);
    let none = turned(67);
    let run = on(&none, &["fetch", "-o", text(&here.join("none.json"))]);
    assert!(run.status == 1 && run.said().contains("there is no calibration"), "{}", run.stderr);
    assert!(!here.join("none.json").exists());
}

#[test]
fn what_is_no_board_is_told_apart() {
    let here = folder("link-no-board");
    let cal = cal_with_effects(&here);
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    // Nobody listens any more at a port that was given back.
    let gone = {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        listener.local_addr().expect("an address").to_string()
    };
    let run = ironout(["send", text(&cal), "--tcp", &gone]);
    assert!(run.status == 2 && run.said().contains("no program listens there"), "{}", run.stderr);
    let run = ironout(["fetch", "-o", "x.json", "--port", "/dev/no-such-port"]);
    assert!(
        run.status == 2 && run.said().contains("cannot open the serial port /dev/no-such-port"),
        "{}",
        run.stderr
    );
    let run = ironout(["fetch", "-o", "x.json"]);
    assert!(run.status == 2 && run.said().contains("--port"), "{}", run.stderr);
    // One that says nothing, one of another speed, one of another kind: each for one connection.
    let other = std::thread::spawn(move || {
        for said in [&b""[..], b"\xf0\x80\x00\xfe\n\x80\xff\n", b"HTTP/1.1 400 Bad Request\r\n"] {
            let (mut client, _) = listener.accept().expect("a client");
            client.write_all(said).expect("said");
            // Until it gives up.
            let _ = client.read_to_end(&mut Vec::new());
        }
    });
    for words in ["no answer for", "not text", "HTTP/1.1 400"] {
        let run = ironout(["send", text(&cal), "--tcp", &address, "--wait", "1"]);
        assert!(run.status == 2 && run.said().contains(words), "{words}: {}", run.stderr);
    }
    other.join().expect("no panic");
}
