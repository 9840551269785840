//! `undula run --live`: the page of a run while it goes on, from this machine to this machine alone.
//!
//! `/` is the page of what there is so far, `/events?after=STEP` a stream of server-sent events: rows after that step.

use crate::report;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use undula::simulation::Row;

/// Rows that are kept for pages that come late.
const ROWS: usize = 5000;

/// Time between two events: rows are sent together.
const PERIOD: Duration = Duration::from_millis(200);

/// How long a browser may take to ask or to listen.
const PATIENCE: Duration = Duration::from_secs(5);

/// The server.
pub struct Live {
    shared: Arc<Shared>,
    /// Its address.
    pub url: String,
}

struct Shared {
    directory: PathBuf,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    rows: VecDeque<(u64, Value)>,
    /// How the run has ended.
    end: Option<String>,
    /// Streams that are open.
    listeners: usize,
}

impl Live {
    /// Serves the page of the run in `directory` on `port`, on any free one if it is 0.
    ///
    /// # Errors
    /// A port that cannot be used.
    pub fn start(directory: &Path, port: u16) -> std::io::Result<Live> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let url = format!("http://{}/", listener.local_addr()?);
        let directory = directory.to_path_buf();
        let shared = Arc::new(Shared { directory, state: Mutex::default(), changed: Condvar::new() });
        let all = shared.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let shared = all.clone();
                // What goes wrong with one browser is its own affair.
                std::thread::spawn(move || drop(shared.answer(&stream)));
            }
        });
        Ok(Live { shared, url })
    }

    /// Tells of a step.
    pub fn row(&self, row: &Row) {
        let values: serde_json::Map<String, Value> =
            row.names().iter().cloned().zip(row.values.iter().map(|&x| json!(x))).collect();
        let event = json!({
            "step": row.step, "time": row.time, "force_time": row.force_time, "values": values,
            "counts": {
                "newton_steps": row.newton_steps, "linear_iterations": row.linear_iterations,
                "jacobians": row.jacobians, "min_J": row.min_j,
            },
        });
        let mut state = self.shared.state();
        state.rows.push_back((row.step, event));
        if state.rows.len() > ROWS {
            state.rows.pop_front();
        }
        drop(state);
        self.shared.changed.notify_all();
    }

    /// Tells how the run has ended, and waits a little until all browsers know.
    pub fn end(self, how: &str) {
        let mut state = self.shared.state();
        state.end = Some(how.to_string());
        self.shared.changed.notify_all();
        for _ in 0..10 {
            if state.listeners == 0 {
                break;
            }
            let waited = self.shared.changed.wait_timeout(state, PERIOD);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Answers one request.
    fn answer(&self, stream: &TcpStream) -> std::io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mut lines = BufReader::new(stream).lines().take(100);
        let first = lines.next().transpose()?.unwrap_or_default();
        let mut is_ours = false;
        for line in lines {
            let line = line?.to_lowercase();
            if line.is_empty() {
                break;
            }
            // Names of other machines that lead here are not asked for by this machine's user.
            is_ours |= line.strip_prefix("host:").is_some_and(|host| {
                let host = host.trim().rsplit_once(':').map_or(host.trim(), |(host, _)| host);
                host == "127.0.0.1" || host == "localhost"
            });
        }
        let path = first.strip_prefix("GET ").and_then(|rest| rest.split(' ').next()).filter(|_| is_ours);
        match path.and_then(|path| path.split_once("?after=").or(Some((path, "0")))) {
            Some(("/", _)) => match report::text(&self.directory, true, &[]) {
                Ok(page) => send(stream, "200 OK", &page),
                Err(_) => send(stream, "503 Service Unavailable", BEGINS),
            },
            // Browsers ask for it.
            Some(("/favicon.ico", _)) => send(stream, "204 No Content", ""),
            Some(("/events", after)) => self.listen(stream, after.parse().unwrap_or(0)),
            _ => send(stream, "404 Not Found", "There is nothing here."),
        }
    }

    /// Sends rows after step `after` as they come.
    fn listen(&self, mut stream: &TcpStream, mut after: u64) -> std::io::Result<()> {
        stream.write_all(
            b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\r\n",
        )?;
        self.state().listeners += 1;
        let ended = loop {
            let state = self.state();
            let news = |state: &mut State| {
                state.end.is_none() && state.rows.back().is_none_or(|(step, _)| *step <= after)
            };
            let waited = self.changed.wait_timeout_while(state, PATIENCE, news);
            let state = waited.unwrap_or_else(PoisonError::into_inner).0;
            let new = state.rows.iter().filter(|(step, _)| *step > after);
            let rows: Vec<&Value> = new.map(|(_, row)| row).collect();
            let event = json!({ "rows": rows, "end": state.end });
            let end = state.end.is_some();
            after = state.rows.back().map_or(after, |(step, _)| after.max(*step));
            drop(state);
            let sent = stream.write_all(format!("data: {event}\n\n").as_bytes());
            if sent.is_err() || end {
                break sent;
            }
            std::thread::sleep(PERIOD);
        };
        self.state().listeners -= 1;
        self.changed.notify_all();
        ended
    }
}

/// What is seen before the directory of the run is there.
const BEGINS: &str = "<!DOCTYPE html><meta http-equiv=\"refresh\" content=\"1\"><p>The run begins.</p>";

fn send(mut stream: &TcpStream, status: &str, text: &str) -> std::io::Result<()> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         Connection: close\r\n\r\n",
        text.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(text.as_bytes())
}
