//! Signals by the names that a dump declares.

use std::borrow::Borrow;
use std::collections::BTreeMap;

use super::edges::Signal;

/// Most bytes of the names that are kept.
const MOST_NAMES: usize = 1 << 20;

/// Expectation and finding.
pub(super) type Wrong = (&'static str, String);

/// A refusal of other bytes than were expected.
pub(super) fn damaged(expected: &'static str) -> Wrong {
    (expected, "a damaged or unfinished dump".into())
}

/// Signals of one bit as a dump declares them, by the codes that its changes name.
#[derive(Debug)]
pub(super) struct Declared<C> {
    pub(super) signals: Vec<Signal>,
    places: BTreeMap<C, usize>,
    scopes: Vec<String>,
    /// Bytes of the names that are kept.
    kept: usize,
}

impl<C: Ord> Declared<C> {
    pub(super) const fn none() -> Self {
        Self {
            signals: Vec::new(),
            places: BTreeMap::new(),
            scopes: Vec::new(),
            kept: 0,
        }
    }

    /// Begins a scope.
    pub(super) fn enter(&mut self, scope: String) -> Result<(), Wrong> {
        self.keep(scope.len() + 1)?;
        self.scopes.push(scope);
        Ok(())
    }

    /// Ends the innermost scope.
    pub(super) fn leave(&mut self) {
        let left = self.scopes.pop().map_or(0, |scope| scope.len() + 1);
        self.kept -= left;
    }

    /// Declares a signal by its name and bit index. A second name of the same code is another address of it.
    pub(super) fn add<'a>(
        &mut self,
        code: C,
        name: impl IntoIterator<Item = &'a str>,
    ) -> Result<(), Wrong> {
        let name: String = name.into_iter().collect();
        let name = name.trim_start_matches('\\').to_owned();
        let scopes = self.scopes.iter().map(String::as_str);
        let path = scopes.chain([&*name]).collect::<Vec<_>>().join(".");
        self.keep(name.len() + path.len())?;
        match self.places.get(&code) {
            Some(place) => self.signals[*place].addresses.extend([name, path]),
            None => {
                self.places.insert(code, self.signals.len());
                self.signals.push(Signal {
                    name,
                    addresses: vec![path],
                    ..Signal::default()
                });
            }
        }
        Ok(())
    }

    /// The place of a code's signal in [`Self::signals`]; none for a signal of another width.
    pub(super) fn place<Q: Ord + ?Sized>(&self, code: &Q) -> Option<usize>
    where
        C: Borrow<Q>,
    {
        self.places.get(code).copied()
    }

    fn keep(&mut self, bytes: usize) -> Result<(), Wrong> {
        self.kept += bytes;
        match self.kept > MOST_NAMES {
            true => Err((
                "names of scopes and signals of at most 1 MiB",
                "more".into(),
            )),
            false => Ok(()),
        }
    }
}
