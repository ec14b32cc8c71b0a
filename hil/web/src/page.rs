//! A page's side of the loop: one session at most, and answers to requests.

use palpate_run::Failure;
use serde::Serialize;
use serde_json::json;

use crate::played::Played;
use crate::request::Request;
use crate::{open, run, shelves};

/// Bytes that most pictures do not exceed.
const ROOM: usize = 1 << 13;

/// State of a page.
#[derive(Default)]
pub struct Page {
    played: Option<Played>,
}

impl Page {
    /// Answers a request: an object with `ok`, or with `error`, a sentence.
    pub fn answer(&mut self, request: &str) -> String {
        let answer = match serde_json::from_str(request) {
            Ok(request) => self.done(request),
            Err(e) => Err(Failure::Input(format!("request: {e}"))),
        };
        answer.unwrap_or_else(|failure| json!({ "error": failure.to_string() }).to_string())
    }

    fn done(&mut self, request: Request) -> Result<String, Failure> {
        match request {
            Request::Shelves => ok(&shelves::shelves()?),
            Request::Open(chosen) => {
                let setup = open::setup(&chosen)?;
                let played = Played::new(setup, chosen.seed.unwrap_or(open::SEED))?;
                let head = ok(&played.head());
                self.played = Some(played);
                head
            }
            Request::Step(step) => {
                let played = self.played.as_mut().ok_or_else(none_open)?;
                played.touch(&step.fingers)?;
                ok(&played.step(step.until_us)?)
            }
            Request::Save => ok(&self.played.as_ref().ok_or_else(none_open)?.save()?),
            Request::End => ok(&self.played.take().ok_or_else(none_open)?.end()?),
            Request::Run(chosen) => {
                let setup = open::setup(&chosen)?;
                ok(&run::run(&setup, chosen.seed.unwrap_or(open::SEED))?)
            }
        }
    }
}

fn none_open() -> Failure {
    Failure::Input("the page: expected an open session; open one first".into())
}

/// Answer to a request that succeeded.
#[derive(Serialize)]
struct Answer<'a, T> {
    ok: &'a T,
}

fn ok<T: Serialize>(answer: &T) -> Result<String, Failure> {
    // Room for a picture, so that its text is not moved as it grows.
    let mut text = Vec::with_capacity(ROOM);
    let written = serde_json::to_writer(&mut text, &Answer { ok: answer });
    written.map_err(|e| Failure::Device(format!("the answer: {e}")))?;
    String::from_utf8(text).map_err(|e| Failure::Device(format!("the answer: {e}")))
}
