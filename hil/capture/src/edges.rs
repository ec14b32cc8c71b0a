//! Signals as their edges.

/// A digital signal.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Signal {
    /// Name in the file.
    pub name: String,
    /// Changes of the signal, in the order of time: nanoseconds since
    /// the start of the capture, and the level after the change.
    pub edges: Vec<(u64, bool)>,
    /// Other names of it: with the scopes around it, and those of its aliases.
    pub addresses: Vec<String>,
    /// Times between which its level is unknown, nanoseconds.
    pub unseen: Vec<(u64, u64)>,
    /// Time since which its level is unknown.
    pub(super) lost: Option<u64>,
}

/// Capture of a logic analyser.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Capture {
    /// Digital signals of the capture.
    pub signals: Vec<Signal>,
    /// Resolution of its times, nanoseconds.
    pub resolution_ns: u64,
    /// Length of the capture, nanoseconds.
    pub end_ns: u64,
    /// Times between which nothing was recorded, nanoseconds.
    pub unrecorded: Vec<(u64, u64)>,
    /// Defects of the file with their lines, and the part of it that was read.
    pub notes: Vec<String>,
}

impl Capture {
    /// Capture of a dump that ends with its signals at `end_ns`.
    pub(super) fn of_dump(mut signals: Vec<Signal>, resolution_ns: u64, end_ns: u64) -> Self {
        for signal in &mut signals {
            let lost = signal.lost.take();
            signal.unseen.extend(lost.map(|from| (from, end_ns)));
        }
        Self {
            signals,
            resolution_ns: resolution_ns.max(1),
            end_ns,
            ..Self::default()
        }
    }
}

impl Signal {
    /// A signal of this name with these edges, whose level is known throughout.
    pub fn new(name: String, edges: Vec<(u64, bool)>) -> Self {
        Self {
            name,
            edges,
            ..Self::default()
        }
    }

    /// Sets the level at a time; false for the same level again, which is no edge.
    pub(super) fn set(&mut self, t_ns: u64, high: bool) -> bool {
        if let Some(from) = self.lost.take() {
            self.unseen.push((from, t_ns));
        }
        let now = self.edges.last().map(|e| e.1);
        let is_edge = now != Some(high) && (now.is_some() || high || t_ns == 0);
        if is_edge {
            self.edges.push((t_ns, high));
        }
        is_edge
    }

    /// Takes a change of a dump: sets the level, or loses sight of one that is unknown. Returns true for an edge.
    pub(super) fn change(&mut self, t_ns: u64, level: Option<bool>) -> bool {
        match level {
            Some(high) => self.set(t_ns, high),
            None => {
                self.lost.get_or_insert(t_ns);
                false
            }
        }
    }

    /// Returns true if the signal has this name, among others.
    #[must_use]
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.addresses.iter().any(|address| address == name)
    }

    /// Whole pulses: rise and width, nanoseconds. One that begins or ends outside of the capture counts if it has
    /// lasted `period_ns` by then, which no pulse does: the output is stuck. One that touches a time that was not seen does not
    /// count.
    pub fn pulses(&self, end_ns: u64, period_ns: u64) -> Vec<(u64, u64)> {
        let ends = (self.edges.iter().skip(1).map(|e| (e.0, false))).chain([(end_ns, true)]);
        let high = self.edges.iter().zip(ends).filter(|(edge, _)| edge.1);
        let pulse = high.filter_map(|(edge, (end, cut))| {
            let width = end.saturating_sub(edge.0);
            let cut = cut || edge.0 == 0;
            let mut unseen = self.unseen.iter();
            if unseen.any(|(from, to)| edge.0 <= *to && end >= *from) {
                return None;
            }
            (!cut || width > period_ns).then_some((edge.0, width))
        });
        pulse.collect()
    }
}
