//! Message of a wearer's glove, a hundred times per second: the angles of the hand's joints.

use palpate_records::mcap::{Described, Visit};

/// Joints of a message at most: a hand has some twenty.
const MOST_JOINTS: usize = 64;

/// Angle of a joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointAngle {
    /// The joint's name.
    pub name: String,
    /// The angle, degrees.
    pub deg: f64,
}

impl<'a> Described<'a> for JointAngle {
    const NAME: &'static str = "JointAngle";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.text("name", &mut self.name);
        visit.real("deg", &mut self.deg);
    }
}

/// Message of a glove.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flexed {
    /// Version of the messages.
    pub version: u32,
    /// The glove's session.
    pub session: u64,
    /// Number of the message in its session, from 1 on.
    pub sequence: u64,
    /// Time of the message, microseconds of the glove's clock.
    pub said_us: u64,
    /// Angles of the joints.
    pub joints: Vec<JointAngle>,
}

impl<'a> Described<'a> for Flexed {
    const NAME: &'static str = "Flexed";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.whole("version", &mut self.version);
        visit.whole("session", &mut self.session);
        visit.whole("sequence", &mut self.sequence);
        visit.whole("said_us", &mut self.said_us);
        // Room for one more shows that there are too many.
        visit.several(&mut self.joints, MOST_JOINTS + 1, |visit, joint| {
            visit.message("joints", joint);
        });
        visit.require(self.joints.len() <= MOST_JOINTS);
    }
}
