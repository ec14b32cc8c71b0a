//! A frame of a skin: its contacts, or one module's readings.

use palpate_core::contact::Contact;
use palpate_core::units::Point;
use palpate_records::mcap::proto::{Message, Value, packed};

use super::{double, each, number};
use crate::judge::Head;

/// Contacts of a frame at most.
const MOST_CONTACTS: usize = 256;

/// Where an emulated skin is truly touched, for what measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Place on the driving module, mm.
    pub at: [f64; 2],
    /// Force, N.
    pub force_n: f64,
}

/// What a frame carries.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// All contacts as of the reading; compression was on the robot's side.
    Touched(Vec<Contact>),
    /// One module's raw counts, along x, y and z for each taxel; compression is on the wearer's side.
    Scanned {
        /// The module.
        module: u16,
        /// Its counts.
        counts: Vec<[u16; 3]>,
    },
}

/// A frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// What it says of itself.
    pub head: Head,
    /// What it carries.
    pub body: Body,
    /// Where the skin is truly touched, where that is known.
    pub truth: Option<Truth>,
}

fn contact(contact: &Contact) -> Message {
    let mut message = Message::default();
    // The fields of `palpate.Contact` in a recording.
    message
        .uint(2, contact.module)
        .uint(3, contact.id)
        .double(4, f64::from(contact.place.x))
        .double(5, f64::from(contact.place.y))
        .double(6, f64::from(contact.intensity))
        .uint(7, contact.level)
        .uint(8, contact.members);
    message
}

fn read_contact(bytes: &[u8]) -> Option<Contact> {
    let mut contact = Contact {
        id: 0,
        module: 0,
        place: Point::new(0.0, 0.0),
        intensity: 0.0,
        level: 0,
        members: 0,
    };
    each(bytes, |field, value| {
        match field {
            2 => contact.module = u16::try_from(number(value)?).ok()?,
            3 => contact.id = u32::try_from(number(value)?).ok()?,
            4 => contact.place.x = double(value)? as f32,
            5 => contact.place.y = double(value)? as f32,
            6 => contact.intensity = double(value)? as f32,
            7 => contact.level = u16::try_from(number(value)?).ok()?,
            8 => contact.members = u32::try_from(number(value)?).ok()?,
            _ => {}
        }
        Some(())
    })?;
    Some(contact)
}

impl Truth {
    fn write(self) -> Message {
        let mut message = Message::default();
        message
            .double(1, self.at[0])
            .double(2, self.at[1])
            .double(3, self.force_n);
        message
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let mut all = [0.0; 3];
        each(bytes, |field, value| {
            if let Some(slot) = all.get_mut(field as usize - 1) {
                *slot = double(value)?;
            }
            Some(())
        })?;
        let [x, y, force_n] = all;
        Some(Self {
            at: [x, y],
            force_n,
        })
    }
}

impl Frame {
    /// Appends the message to what is there.
    pub fn write(&self, message: &mut Message) {
        let head = &self.head;
        message
            .uint(1, head.version)
            .uint(2, head.session)
            .uint(3, head.sequence)
            .uint(4, head.sent_us)
            .uint(5, head.taken_us)
            .uint(6, head.layout);
        if let Some(truth) = self.truth {
            message.inner(7, &truth.write());
        }
        match &self.body {
            Body::Touched(contacts) => {
                for one in contacts {
                    message.inner(8, &contact(one));
                }
            }
            Body::Scanned { module, counts } => {
                message.uint(8, *module);
                for axis in 0..3 {
                    message.packed(9 + axis as u32, counts.iter().map(|c| c[axis]));
                }
            }
        }
    }

    /// A message of contacts; `None` where it is damaged.
    #[must_use]
    pub fn touched(bytes: &[u8]) -> Option<Self> {
        let (mut head, mut truth, mut contacts) = (NO_HEAD, None, Vec::new());
        each(bytes, |field, value| {
            match (field, value) {
                (7, Value::Data(bytes)) => truth = Some(Truth::read(bytes)?),
                (8, Value::Data(bytes)) if contacts.len() < MOST_CONTACTS => {
                    contacts.push(read_contact(bytes)?);
                }
                (8, _) => return None,
                _ => head_field(&mut head, field, value)?,
            }
            Some(())
        })?;
        Some(Self {
            head,
            truth,
            body: Body::Touched(contacts),
        })
    }

    /// A message of readings; `None` where it is damaged.
    #[must_use]
    pub fn scanned(bytes: &[u8]) -> Option<Self> {
        let (mut head, mut truth, mut module) = (NO_HEAD, None, 0);
        let mut axes: [Vec<u16>; 3] = Default::default();
        each(bytes, |field, value| {
            match (field, value) {
                (7, Value::Data(bytes)) => truth = Some(Truth::read(bytes)?),
                (8, value) => module = u16::try_from(number(value)?).ok()?,
                (9..=11, Value::Data(bytes)) => axes[field as usize - 9] = packed(bytes)?,
                (9..=11, _) => return None,
                _ => head_field(&mut head, field, value)?,
            }
            Some(())
        })?;
        let [x, y, z] = axes;
        let taxels = x.len().max(y.len()).max(z.len());
        // An axis that a skin lacks is left out whole.
        let fits = |axis: &[u16]| axis.is_empty() || axis.len() == taxels;
        if ![&x, &y, &z].into_iter().all(|axis| fits(axis)) {
            return None;
        }
        let of = |axis: &[u16], taxel: usize| axis.get(taxel).copied().unwrap_or(0);
        let counts = (0..taxels).map(|t| [of(&x, t), of(&y, t), of(&z, t)]);
        Some(Self {
            head,
            truth,
            body: Body::Scanned {
                module,
                counts: counts.collect(),
            },
        })
    }
}

const NO_HEAD: Head = Head {
    version: 0,
    session: 0,
    sequence: 0,
    sent_us: 0,
    taken_us: 0,
    layout: 0,
};

fn head_field(head: &mut Head, field: u32, value: Value<'_>) -> Option<()> {
    match field {
        1 => head.version = u32::try_from(number(value)?).ok()?,
        2 => head.session = number(value)?,
        3 => head.sequence = number(value)?,
        4 => head.sent_us = number(value)?,
        5 => head.taken_us = number(value)?,
        6 => head.layout = number(value)?,
        _ => {}
    }
    Some(())
}
