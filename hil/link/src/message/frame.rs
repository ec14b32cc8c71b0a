//! A frame of a skin: its contacts, or one module's readings.

use std::array::from_fn;

use palpate_core::contact::Contact;
use palpate_records::mcap::proto::{Message, pack, packed};
use palpate_records::mcap::{Described, FieldKind, Visit, decode, encode};

use crate::judge::Head;

/// Contacts of a frame at most.
const MOST_CONTACTS: usize = 256;

/// True touch of an emulated skin, for measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Place on the driving module, mm.
    pub at: [f64; 2],
    /// Force, N.
    pub force_n: f64,
}

/// Content of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// All contacts as of the reading; compression was on the robot's side.
    Touched(Vec<Contact>),
    /// One module's raw counts, along x, y and z for each taxel; compression is on the wearer's side.
    Scanned {
        /// Number of the module.
        module: u16,
        /// Counts of the module.
        counts: Vec<[u16; 3]>,
    },
}

/// A frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Head of the frame.
    pub head: Head,
    /// Content of the frame.
    pub body: Body,
    /// True touch, where that is known.
    pub truth: Option<Truth>,
    /// Number of the glove's message that the skin was under; 0 without a glove.
    pub flexed: u64,
}

impl<'a> Described<'a> for Truth {
    const NAME: &'static str = "Truth";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.real("x_mm", &mut self.at[0]);
        visit.real("y_mm", &mut self.at[1]);
        visit.real("force_n", &mut self.force_n);
    }
}

/// The fields that both kinds of frame begin with.
fn begin<'a>(head: &mut Head, truth: &mut Option<Truth>, visit: &mut impl Visit<'a>) {
    visit.whole("version", &mut head.version);
    visit.whole("session", &mut head.session);
    visit.whole("sequence", &mut head.sequence);
    visit.whole("sent_us", &mut head.sent_us);
    visit.whole("taken_us", &mut head.taken_us);
    visit.whole("layout", &mut head.layout);
    let mut known: Vec<Truth> = truth.take().into_iter().collect();
    visit.several(&mut known, 1, |visit, truth| visit.message("truth", truth));
    *truth = known.pop();
}

/// The contacts of a frame, as a message.
#[derive(Default)]
pub(crate) struct Touched {
    head: Head,
    truth: Option<Truth>,
    contacts: Vec<Contact>,
    flexed: u64,
}

impl<'a> Described<'a> for Touched {
    const NAME: &'static str = "Touched";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        begin(&mut self.head, &mut self.truth, visit);
        // Room for one more shows that there are too many.
        visit.several(&mut self.contacts, MOST_CONTACTS + 1, |visit, contact| {
            visit.message("contacts", contact);
        });
        visit.require(self.contacts.len() <= MOST_CONTACTS);
        visit.whole("flexed", &mut self.flexed);
    }
}

/// One module's readings, as a message: packed counts for each axis.
#[derive(Default)]
pub(crate) struct Scanned<'a> {
    head: Head,
    truth: Option<Truth>,
    module: u16,
    axes: [&'a [u8]; 3],
    flexed: u64,
}

impl<'a> Described<'a> for Scanned<'a> {
    const NAME: &'static str = "Scanned";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        begin(&mut self.head, &mut self.truth, visit);
        visit.whole("module", &mut self.module);
        for (name, counts) in ["x", "y", "z"].into_iter().zip(&mut self.axes) {
            visit.data(name, FieldKind::Counts, counts);
        }
        visit.whole("flexed", &mut self.flexed);
    }
}

impl Frame {
    /// Writes the message in place of earlier content.
    pub fn write(&self, message: &mut Message) {
        let (head, truth, flexed) = (self.head, self.truth, self.flexed);
        match &self.body {
            Body::Touched(contacts) => {
                let contacts = contacts.clone();
                let mut touched = Touched {
                    head,
                    truth,
                    contacts,
                    flexed,
                };
                encode(&mut touched, message);
            }
            Body::Scanned { module, counts } => {
                let axes: [_; 3] = from_fn(|axis| pack(counts.iter().map(|c| c[axis])));
                let mut scanned = Scanned {
                    head,
                    truth,
                    module: *module,
                    axes: axes.each_ref().map(Message::bytes),
                    flexed,
                };
                encode(&mut scanned, message);
            }
        }
    }

    /// A message of contacts; `None` where it is damaged.
    #[must_use]
    pub fn touched(bytes: &[u8]) -> Option<Self> {
        let touched: Touched = decode(bytes)?;
        Some(Self {
            head: touched.head,
            truth: touched.truth,
            body: Body::Touched(touched.contacts),
            flexed: touched.flexed,
        })
    }

    /// A message of readings; `None` where it is damaged.
    #[must_use]
    pub fn scanned(bytes: &[u8]) -> Option<Self> {
        let scanned: Scanned<'_> = decode(bytes)?;
        let [x, y, z] = scanned.axes.map(packed);
        let (x, y, z) = (x?, y?, z?);
        let taxels = x.len().max(y.len()).max(z.len());
        // An axis that a skin lacks is left out whole.
        let fits = |axis: &[u16]| axis.is_empty() || axis.len() == taxels;
        if ![&x, &y, &z].into_iter().all(|axis| fits(axis)) {
            return None;
        }
        let of = |axis: &[u16], taxel: usize| axis.get(taxel).copied().unwrap_or(0);
        let counts = (0..taxels).map(|t| [of(&x, t), of(&y, t), of(&z, t)]);
        Some(Self {
            head: scanned.head,
            truth: scanned.truth,
            body: Body::Scanned {
                module: scanned.module,
                counts: counts.collect(),
            },
            flexed: scanned.flexed,
        })
    }
}
