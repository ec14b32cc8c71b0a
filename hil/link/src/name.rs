//! Names of robots, hands, fingers and wearers, and the keys that they make.

use core::fmt;
use core::str::FromStr;

/// The first part of every key.
pub const ROOT: &str = "palpate";

/// A part of a key: lower-case letters, digits and hyphens.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Name(String);

impl Name {
    /// Text of the name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for Name {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if (1..=64).contains(&text.len()) && text.chars().all(fits) {
            return Ok(Self(text.to_owned()));
        }
        Err("expected 1 to 64 lower-case letters, digits and hyphens".into())
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A finger of a robot.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FingerName {
    /// The robot.
    pub robot: Name,
    /// The robot's hand.
    pub hand: Name,
    /// The finger of that hand.
    pub finger: Name,
}

impl FromStr for FingerName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split('/').collect();
        let [robot, hand, finger] = parts[..] else {
            return Err("expected ROBOT/HAND/FINGER, such as r1/left/index".into());
        };
        Ok(Self {
            robot: robot.parse()?,
            hand: hand.parse()?,
            finger: finger.parse()?,
        })
    }
}

impl fmt::Display for FingerName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.robot, self.hand, self.finger)
    }
}

impl FingerName {
    fn key(&self, rest: &str) -> String {
        format!("{ROOT}/{self}/{rest}")
    }

    /// Key of contacts.
    #[must_use]
    pub fn contacts(&self) -> String {
        self.key("contacts")
    }

    /// Key of scans.
    #[must_use]
    pub fn scans(&self) -> String {
        self.key("scans")
    }

    /// Key under which frames of `key` come a second time, over another connection.
    #[must_use]
    pub fn again(key: &str) -> String {
        format!("{key}/again")
    }

    /// Key under which a publisher answers with its facts.
    #[must_use]
    pub fn about(&self) -> String {
        self.key("about")
    }

    /// Key of a wearer's messages; `*` for all.
    #[must_use]
    pub fn wearer(&self, wearer: &str) -> String {
        self.key(&format!("wearers/{wearer}"))
    }

    /// Key of the messages of a wearer's glove.
    #[must_use]
    pub fn flexion(&self, wearer: &Name) -> String {
        self.key(&format!("flexion/{wearer}"))
    }

    /// Key of answers to a wearer.
    #[must_use]
    pub fn echo(&self, wearer: &Name) -> String {
        self.key(&format!("echo/{wearer}"))
    }

    /// The token of a publisher that is there; `*` for all.
    #[must_use]
    pub fn skin_alive(&self, session: &str) -> String {
        self.key(&format!("alive/skin/{session}"))
    }

    /// The token of a wearer who is there.
    #[must_use]
    pub fn wearer_alive(&self, wearer: &Name) -> String {
        self.key(&format!("alive/wearer/{wearer}"))
    }
}

#[cfg(test)]
#[path = "name_tests.rs"]
mod tests;
