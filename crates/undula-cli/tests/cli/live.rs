//! `undula run --live`: a browser is played by requests over a socket.

use super::{Place, wait};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};

/// Ends with the test, whatever happens.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn ask(port: &str, path: &str, host: &str) -> TcpStream {
    let mut stream = TcpStream::connect(format!("127.0.0.1:{port}")).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
    stream
}

fn whole(port: &str, path: &str, host: &str) -> String {
    let mut text = String::new();
    ask(port, path, host).read_to_string(&mut text).unwrap();
    text
}

/// The next event of a stream.
fn event(stream: &mut impl BufRead) -> Value {
    loop {
        let mut line = String::new();
        assert!(stream.read_line(&mut line).unwrap() > 0, "the stream has ended");
        if let Some(data) = line.strip_prefix("data: ") {
            return serde_json::from_str(data).unwrap();
        }
    }
}

#[test]
fn a_run_is_seen_while_it_goes_on_and_its_end_is_told() {
    let here = Place::new("live");
    let sets = ["mesh.refine=0", "time.step=0.002", "time.end=1000", "output.fields-every=10"];
    let mut command = here.command("run fsi3 -o out --live", &sets);
    let mut child = Running(command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap());
    let mut said = BufReader::new(child.0.stderr.take().unwrap());
    let mut line = String::new();
    while !line.starts_with("live page") {
        line.clear();
        assert!(said.read_line(&mut line).unwrap() > 0, "no address was told");
    }
    let port = line.trim().trim_end_matches('/').rsplit(':').next().unwrap().to_string();
    // The page has what there is so far.
    let page = wait("a page with charts", || {
        let page = whole(&port, "/", "localhost:1");
        page.contains("history-charts").then_some(page)
    });
    assert!(
        page.starts_with("HTTP/1.1 200 OK")
            && page.contains("fsi3: Turek-Hron")
            && page.contains("EventSource")
    );
    assert!(page.contains(">running<"));
    // Rows come one after the other, those before a step are left out.
    let mut stream = BufReader::new(ask(&port, "/events?after=3", &format!("127.0.0.1:{port}")));
    let mut steps = vec![];
    while steps.len() < 5 {
        for row in event(&mut stream)["rows"].as_array().unwrap() {
            steps.push(row["step"].as_u64().unwrap());
            assert!(row["values"]["drag"].is_f64() && row["counts"]["newton_steps"].is_u64(), "{row}");
        }
    }
    assert!(steps[0] == 4 && steps.windows(2).all(|pair| pair[1] == pair[0] + 1), "{steps:?}");
    assert!(whole(&port, "/nothing", "localhost").starts_with("HTTP/1.1 404"));
    assert!(whole(&port, "/", "elsewhere.example").starts_with("HTTP/1.1 404"));
    // The end.
    let pid = child.0.id().to_string();
    std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap();
    let end = wait("the end", || event(&mut stream)["end"].as_str().map(String::from));
    assert_eq!(end, "interrupted");
    assert_eq!(child.0.wait().unwrap().code(), Some(130));
}

#[test]
fn a_port_that_is_taken_is_bad_input() {
    let here = Place::new("live-port");
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    here.run(&format!("run fsi3 -o out --live={port}"), &super::SMALL).expect(2, &["another port"]);
    assert!(!here.file("out").exists());
}
