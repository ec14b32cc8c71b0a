//! Admission of requests: from a page of this program's own, by a name of this computer, or from one that has the
//! token.
//!
//! Any page of any site can ask a browser to open a socket to this computer. Its `Origin` says so, and a name that was
//! bent to this computer (DNS rebinding) stands in `Host`.

use std::net::{IpAddr, SocketAddr};

use palpate_run::Failure;

use super::http::Request;
use crate::link::key::random;

/// Rules for requests.
#[derive(Clone, Debug)]
pub(super) struct Gate {
    /// Tokens that sockets need where other computers may come, one for each page; empty elsewhere.
    tokens: Vec<String>,
}

impl Gate {
    /// A gate for a server of so many pages at this address: on a loopback address names of this computer are enough.
    ///
    /// # Errors
    /// [`Failure::Device`] for a system without random bytes.
    pub(super) fn at(address: SocketAddr, pages: usize) -> Result<Self, Failure> {
        let make = |_| -> Result<String, Failure> {
            let bytes = random::<16>()?;
            Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
        };
        let needed = if address.ip().is_loopback() { 0 } else { pages };
        let tokens = (0..needed).map(make).collect::<Result<_, Failure>>()?;
        Ok(Self { tokens })
    }

    /// The address of a page by its path and number, with its token if it has one. A browser keeps the part behind the
    /// `#` to itself.
    pub(super) fn url(&self, address: SocketAddr, path: &str, page: usize) -> String {
        let token = self.tokens.get(page);
        let token = token.map(|token| format!("#token={token}"));
        format!("http://{address}/{path}{}", token.unwrap_or_default())
    }

    /// Tells whether a socket needs a token.
    pub(super) const fn wants_token(&self) -> bool {
        !self.tokens.is_empty()
    }

    /// Checks that a request may have a file of the page. The error is a sentence.
    pub(super) fn admits(&self, request: &Request) -> Result<(), &'static str> {
        let plain = |c: char| c.is_ascii_alphanumeric() || ".:-[]".contains(c);
        if request.host.is_empty() || !request.host.chars().all(plain) {
            return Err("Host: expected the address of this server");
        }
        match self.wants_token() || is_this_computer(&request.host) {
            true => Ok(()),
            false => Err("Host: expected localhost or a loopback address"),
        }
    }

    /// Checks that a request may have a socket. Returns the number of the page whose token it shows, where one is
    /// needed. The error is a sentence.
    pub(super) fn admits_socket(&self, request: &Request) -> Result<Option<usize>, &'static str> {
        self.admits(request)?;
        if request.origin.strip_prefix("http://") != Some(&request.host) {
            return Err("Origin: expected this server's own page");
        }
        if !self.wants_token() {
            return Ok(None);
        }
        let is_own = |token: &str| self.tokens.iter().position(|own| own == token);
        match request.token().and_then(is_own) {
            Some(page) => Ok(Some(page)),
            None => Err("token: expected the one that hil printed"),
        }
    }
}

/// Tells whether a host, with or without a port, is a name of this computer.
pub(super) fn is_this_computer(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.parse::<u16>().is_ok() => name,
        _ => host,
    };
    let address = name.trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost")
        || address.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
}
