//! The messages of ROS 2 that contacts fit: their types, hashes and bytes. Lengths are metres there.

use palpate_core::contact::Contact;

use super::cdr::Cdr;

/// A type of message. The hash is a constant of its definition.
#[derive(Clone, Copy, Debug)]
pub struct Topic {
    /// Package of the type, such as `geometry_msgs`.
    pub package: &'static str,
    /// Name of the type, such as `PointStamped`.
    pub name: &'static str,
    /// Hash of the definition (RIHS01).
    pub hash: &'static str,
}

/// `geometry_msgs/msg/PointStamped`: the strongest contact.
pub const POINT: Topic = Topic {
    package: "geometry_msgs",
    name: "PointStamped",
    hash: "RIHS01_4c0296af86e01e562e9e0405d138a01537247580076c58ea38d7923ac1045897",
};

/// `visualization_msgs/msg/MarkerArray`: all contacts, for RViz and Foxglove.
pub const MARKERS: Topic = Topic {
    package: "visualization_msgs",
    name: "MarkerArray",
    hash: "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
};

/// Time and frame of reference: `std_msgs/Header`.
#[derive(Clone, Debug)]
pub struct Stamp {
    seconds: i32,
    nanoseconds: u32,
    frame: String,
}

impl Stamp {
    /// Stamp of nanoseconds since 1970, in this frame of reference.
    #[must_use]
    pub fn new(unix_ns: i64, frame: &str) -> Self {
        let (seconds, rest) = (
            unix_ns.div_euclid(1_000_000_000),
            unix_ns.rem_euclid(1_000_000_000),
        );
        Self {
            seconds: i32::try_from(seconds).unwrap_or(i32::MAX),
            nanoseconds: rest as u32, // below 10^9
            frame: frame.into(),
        }
    }

    fn write(&self, cdr: &mut Cdr) {
        cdr.i32(self.seconds)
            .u32(self.nanoseconds)
            .text(&self.frame);
    }
}

fn metres(contact: &Contact) -> [f64; 3] {
    [
        f64::from(contact.place.x) * 1e-3,
        f64::from(contact.place.y) * 1e-3,
        0.0,
    ]
}

/// A contact's place.
#[must_use]
pub fn point(stamp: &Stamp, contact: &Contact) -> Vec<u8> {
    let mut cdr = Cdr::new();
    stamp.write(&mut cdr);
    for value in metres(contact) {
        cdr.f64(value);
    }
    cdr.bytes()
}

/// Lifetime of a mark unless the next frame has it again, nanoseconds.
const LIFETIME_NS: u32 = 100_000_000;

/// Every contact as a sphere, wider where it is stronger.
#[must_use]
pub fn markers(stamp: &Stamp, contacts: &[Contact]) -> Vec<u8> {
    const SPHERE: i32 = 2;
    let mut cdr = Cdr::new();
    cdr.u32(contacts.len() as u32); // 256 at most
    for contact in contacts {
        stamp.write(&mut cdr);
        cdr.text("contacts")
            .i32(contact.id.cast_signed())
            .i32(SPHERE)
            .i32(0);
        for value in metres(contact) {
            cdr.f64(value);
        }
        for value in [0.0, 0.0, 0.0, 1.0] {
            cdr.f64(value);
        }
        let size = 1e-3 * (1.0 + f64::from(contact.intensity.max(0.0)).sqrt() * 0.1).min(5.0);
        cdr.f64(size).f64(size).f64(size);
        // The colour is orange.
        cdr.f32(1.0).f32(0.45).f32(0.0).f32(1.0);
        cdr.i32(0).u32(LIFETIME_NS).u8(0);
        // No points, colours, texture, text or mesh.
        cdr.u32(0).u32(0).text("");
        stamp.write_none(&mut cdr);
    }
    cdr.bytes()
}

impl Stamp {
    /// Writes the unused end of a marker: texture, its coordinates, text, mesh and its file.
    fn write_none(&self, cdr: &mut Cdr) {
        cdr.i32(0).u32(0).text(""); // texture: header
        cdr.text("").u32(0); // its format and data
        cdr.u32(0); // uv_coordinates
        cdr.text(""); // text
        cdr.text(""); // mesh_resource
        cdr.text("").u32(0); // mesh_file: filename, data
        cdr.u8(0); // mesh_use_embedded_materials
    }
}
