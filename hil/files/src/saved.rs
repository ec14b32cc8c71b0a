//! A scene as it was played, as the text of a new scene: changes and the touches of fingers are in place.

use toml::{Table, Value};

use super::error::FileError;
use super::loaded::Loaded;
use super::scene::Scene;
use super::touch::Touch;

impl Loaded<Scene> {
    /// The text of this scene with all of its changes, `length_s` long, and `fingers` among its touches. Its levels
    /// are dynamic, as those of a session without an end. The scene's expectations are left out.
    ///
    /// # Errors
    /// The errors of reading the scene, which has succeeded before.
    pub fn saved(&self, length_s: f64, fingers: &[Touch]) -> Result<String, FileError> {
        let whole = |what: &str| FileError::whole(self.source.label(), what, "another text");
        let Value::Table(mut scene) = self.source.value()? else {
            return Err(whole("a TOML table"));
        };
        scene.remove("expect");
        let text = |text: String| Value::String(text);
        scene.insert(
            "name".into(),
            text(format!(
                "{}-touched",
                self.value.name.trim_end_matches("-touched")
            )),
        );
        scene.insert("length_s".into(), Value::Float(length_s));
        let compression = scene
            .entry("compression")
            .or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(table) = compression {
            table.insert("levels".into(), text("dynamic".into()));
        }
        let touches = scene
            .entry("touches")
            .or_insert_with(|| Value::Array(Vec::new()));
        if let Value::Array(touches) = touches {
            // A touch without a stated end lasted as long as the scene, which has another length now.
            for (file, touch) in touches.iter_mut().zip(&self.value.touches) {
                if let Value::Table(file) = file {
                    file.insert("end_s".into(), Value::Float(touch.end_s));
                }
            }
            touches.extend(fingers.iter().map(by_hand));
        }
        if matches!(scene.get("touches"), Some(Value::Array(none)) if none.is_empty()) {
            scene.remove("touches");
        }
        toml::to_string(&scene).map_err(|_| whole("values that TOML can hold"))
    }
}

fn by_hand(touch: &Touch) -> Value {
    let samples = touch.path.samples.iter();
    let sample = |s: &[i64; 5]| Value::Array(s.iter().map(|v| Value::Integer(*v)).collect());
    let path = [
        ("kind".into(), Value::String("hand".into())),
        (
            "samples".into(),
            Value::Array(samples.map(sample).collect()),
        ),
    ];
    let keys = [
        ("module".into(), Value::Integer(touch.module as i64)),
        ("start_s".into(), Value::Float(touch.start_s)),
        ("end_s".into(), Value::Float(touch.end_s)),
        ("path".into(), Value::Table(path.into_iter().collect())),
    ];
    Value::Table(keys.into_iter().collect())
}
