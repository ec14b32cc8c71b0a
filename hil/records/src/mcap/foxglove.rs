//! Foxglove's own messages, as it publishes them: one table, from which the descriptors in the file follow.
//! `ci/readers` holds every field against the published ones.

use super::proto::Message;
use super::schema::{Field, field, file};

/// Messages that log panels show.
pub const LOG: &str = "foxglove.Log";
/// Points with a value each.
pub const CLOUD: &str = "foxglove.PointCloud";
/// Shapes of a scene.
pub const SCENE: &str = "foxglove.SceneUpdate";
/// Name of the message for the place of a frame of reference in another.
pub const TRANSFORM: &str = "foxglove.FrameTransform";

/// A line per message or enumeration: its name, its fields in the order of their numbers. A star is repeated.
const TYPES: &str = "\
google.protobuf.Timestamp seconds:int64 nanos:int32
google.protobuf.Duration seconds:int64 nanos:int32
enum foxglove.Log.Level UNKNOWN=0 DEBUG=1 INFO=2 WARNING=3 ERROR=4 FATAL=5
foxglove.Log timestamp:google.protobuf.Timestamp level:foxglove.Log.Level message:string name:string file:string line:fixed32
foxglove.Vector3 x:double y:double z:double
foxglove.Quaternion x:double y:double z:double w:double
foxglove.Pose position:foxglove.Vector3 orientation:foxglove.Quaternion
enum foxglove.PackedElementField.NumericType UNKNOWN=0 UINT8=1 INT8=2 UINT16=3 INT16=4 UINT32=5 INT32=6 FLOAT32=7 FLOAT64=8
foxglove.PackedElementField name:string offset:fixed32 type:foxglove.PackedElementField.NumericType
foxglove.PointCloud timestamp:google.protobuf.Timestamp frame_id:string pose:foxglove.Pose point_stride:fixed32 fields:*foxglove.PackedElementField data:bytes
foxglove.FrameTransform timestamp:google.protobuf.Timestamp parent_frame_id:string child_frame_id:string translation:foxglove.Vector3 rotation:foxglove.Quaternion
enum foxglove.SceneEntityDeletion.Type MATCHING_ID=0 ALL=1
foxglove.SceneEntityDeletion timestamp:google.protobuf.Timestamp type:foxglove.SceneEntityDeletion.Type id:string
foxglove.KeyValuePair key:string value:string
foxglove.Color r:double g:double b:double a:double
foxglove.ArrowPrimitive pose:foxglove.Pose shaft_length:double shaft_diameter:double head_length:double head_diameter:double color:foxglove.Color
foxglove.CubePrimitive pose:foxglove.Pose size:foxglove.Vector3 color:foxglove.Color
foxglove.SpherePrimitive pose:foxglove.Pose size:foxglove.Vector3 color:foxglove.Color
foxglove.CylinderPrimitive pose:foxglove.Pose size:foxglove.Vector3 bottom_scale:double top_scale:double color:foxglove.Color
enum foxglove.LinePrimitive.Type LINE_STRIP=0 LINE_LOOP=1 LINE_LIST=2
foxglove.Point3 x:double y:double z:double
foxglove.LinePrimitive type:foxglove.LinePrimitive.Type pose:foxglove.Pose thickness:double scale_invariant:bool points:*foxglove.Point3 color:foxglove.Color colors:*foxglove.Color indices:*fixed32
foxglove.TriangleListPrimitive pose:foxglove.Pose points:*foxglove.Point3 color:foxglove.Color colors:*foxglove.Color indices:*fixed32
foxglove.TextPrimitive pose:foxglove.Pose billboard:bool font_size:double scale_invariant:bool color:foxglove.Color text:string
foxglove.ModelPrimitive pose:foxglove.Pose scale:foxglove.Vector3 color:foxglove.Color override_color:bool url:string media_type:string data:bytes
foxglove.SceneEntity timestamp:google.protobuf.Timestamp frame_id:string id:string lifetime:google.protobuf.Duration frame_locked:bool metadata:*foxglove.KeyValuePair arrows:*foxglove.ArrowPrimitive cubes:*foxglove.CubePrimitive spheres:*foxglove.SpherePrimitive cylinders:*foxglove.CylinderPrimitive lines:*foxglove.LinePrimitive triangles:*foxglove.TriangleListPrimitive texts:*foxglove.TextPrimitive models:*foxglove.ModelPrimitive
foxglove.SceneUpdate deletions:*foxglove.SceneEntityDeletion entities:*foxglove.SceneEntity
";

/// The values of an enumeration.
fn values(name: &str, words: &str) -> Message {
    let mut all = Message::default();
    all.text(1, name);
    for (name, number) in words.split(' ').filter_map(|w| w.split_once('=')) {
        let mut value = Message::default();
        value
            .text(1, name)
            .uint(2, number.parse::<u32>().unwrap_or(0));
        all.inner(2, &value);
    }
    all
}

/// The messages of a package.
fn package(package: &str) -> Vec<Message> {
    let prefix = format!("{package}.");
    let mut found = Vec::new();
    for line in TYPES.lines() {
        let Some((name, fields)) = line.strip_prefix(&prefix).and_then(|l| l.split_once(' '))
        else {
            continue;
        };
        let mut message = Message::default();
        message.text(1, name);
        for (number, word) in (1..).zip(fields.split(' ')) {
            let (name, of) = word.split_once(':').unwrap_or((word, "string"));
            let kind = of.trim_start_matches('*');
            let of = Field {
                name,
                number,
                kind,
                is_enum: TYPES.contains(&format!("enum {kind} ")),
                repeated: of.starts_with('*'),
            };
            message.inner(2, &field(&of));
        }
        let nested = format!("enum {prefix}{name}.");
        for line in TYPES.lines().filter_map(|l| l.strip_prefix(&nested)) {
            let (name, words) = line.split_once(' ').unwrap_or((line, ""));
            message.inner(4, &values(name, words));
        }
        found.push(message);
    }
    found
}

/// A `google.protobuf.FileDescriptorSet` of all of them.
pub fn descriptor() -> Vec<u8> {
    let google = "google/protobuf/time.proto";
    let mut set = Message::default();
    set.inner(
        1,
        &file(google, "google.protobuf", "", &package("google.protobuf")),
    )
    .inner(
        1,
        &file(
            "foxglove/foxglove.proto",
            "foxglove",
            google,
            &package("foxglove"),
        ),
    );
    set.bytes().to_vec()
}
