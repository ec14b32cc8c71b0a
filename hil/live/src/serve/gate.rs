//! Who may look: a page of this program's own, by a name of this computer, or one that has the token.
//!
//! Any page of any site can ask a browser to open a socket to this computer. Its `Origin` says so, and a name that was
//! bent to this computer (DNS rebinding) stands in `Host`.

use std::net::{IpAddr, SocketAddr};

use palpate_run::Failure;

use super::http::Request;
use crate::link::key::random;

/// What is asked of requests.
#[derive(Clone, Debug)]
pub(super) struct Gate {
    /// What a socket has to show where other computers may come.
    token: Option<String>,
}

impl Gate {
    /// For a server at this address: on a loopback address names of this computer are enough.
    ///
    /// # Errors
    /// [`Failure::Device`] for a system without random bytes.
    pub(super) fn at(address: SocketAddr) -> Result<Self, Failure> {
        let make = || {
            Ok::<_, Failure>(
                random::<16>()?
                    .iter()
                    .map(|byte| format!("{byte:02x}"))
                    .collect(),
            )
        };
        let token = (!address.ip().is_loopback()).then(make).transpose()?;
        Ok(Self { token })
    }

    /// The address of the page, with the token if there is one. A browser sends nothing of what stands behind the `#`.
    pub(super) fn url(&self, address: SocketAddr) -> String {
        let token = self.token.as_ref().map(|token| format!("#token={token}"));
        format!("http://{address}/{}", token.unwrap_or_default())
    }

    /// Whether a socket needs a token.
    pub(super) const fn wants_token(&self) -> bool {
        self.token.is_some()
    }

    /// Whether a request may have a file of the page; a sentence where not.
    pub(super) fn admits(&self, request: &Request) -> Result<(), &'static str> {
        let plain = |c: char| c.is_ascii_alphanumeric() || ".:-[]".contains(c);
        if request.host.is_empty() || !request.host.chars().all(plain) {
            return Err("Host: expected the address of this server");
        }
        match self.token.is_some() || is_this_computer(&request.host) {
            true => Ok(()),
            false => Err("Host: expected localhost or a loopback address"),
        }
    }

    /// Whether a request may have a socket; a sentence where not.
    pub(super) fn admits_socket(&self, request: &Request) -> Result<(), &'static str> {
        self.admits(request)?;
        if request.origin.strip_prefix("http://") != Some(&request.host) {
            return Err("Origin: expected this server's own page");
        }
        match &self.token {
            Some(token) if request.token() != Some(token) => {
                Err("token: expected the one that hil printed")
            }
            _ => Ok(()),
        }
    }
}

fn is_this_computer(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.parse::<u16>().is_ok() => name,
        _ => host,
    };
    let address = name.trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost")
        || address.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
}
