//! The access list of a lab: rights to publish and to feel fingers. A file, and zenoh's rules from it.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::name::{Name, ROOT};

/// A machine or program of the lab.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    /// The name in its certificate.
    pub name: String,
    /// Fingers that it may publish: ROBOT/HAND/FINGER, `*` for any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub publishes: Vec<String>,
    /// Fingers that it may feel.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub feels: Vec<String>,
    /// `true` where the member may read everything: lists and recordings.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub watches: bool,
    /// `true` where the member passes on what others say. It is trusted to hold them to this list.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub relays: bool,
}

/// The access list.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Access {
    /// Members of the lab.
    #[serde(default, rename = "member")]
    pub members: Vec<Member>,
}

/// Tells whether a text is three parts of a key, each a name or `*`.
fn is_pattern(text: &str) -> bool {
    let parts: Vec<&str> = text.split('/').collect();
    parts.len() == 3 && parts.iter().all(|p| *p == "*" || p.parse::<Name>().is_ok())
}

/// Tells whether a pattern has this finger.
fn has(pattern: &str, finger: &str) -> bool {
    let (pattern, finger) = (pattern.split('/'), finger.split('/'));
    pattern.zip(finger).all(|(p, f)| p == "*" || p == f)
}

impl Access {
    /// Reads and checks one; `path` is for what is said of it.
    ///
    /// # Errors
    /// What is wrong, where, and what was expected.
    pub fn read(path: &Path, text: &str) -> Result<Self, String> {
        let place = path.display();
        let access: Self = toml::from_str(text).map_err(|e| format!("{place}: {e}"))?;
        for (number, member) in access.members.iter().enumerate() {
            let place = format!("{place}: member[{number}]");
            let name = &member.name;
            name.parse::<Name>()
                .map_err(|e| format!("{place}.name: {e}, found {name:?}"))?;
            if access.members[..number].iter().any(|m| m.name == *name) {
                return Err(format!(
                    "{place}.name: expected each name once, found {name:?} again"
                ));
            }
            for pattern in member.publishes.iter().chain(&member.feels) {
                if !is_pattern(pattern) {
                    return Err(format!(
                        "{place}: expected ROBOT/HAND/FINGER with names or *, found {pattern:?}"
                    ));
                }
            }
        }
        Ok(access)
    }

    /// Tells whether a member may publish a finger.
    #[must_use]
    pub fn may_publish(&self, name: &str, finger: &str) -> bool {
        let members = self.members.iter().filter(|m| m.name == name);
        let mut patterns = members.flat_map(|m| &m.publishes);
        patterns.any(|pattern| has(pattern, finger))
    }

    /// Zenoh's rules. Everything that is not allowed is denied, in silence.
    #[must_use]
    pub fn settings(&self) -> Value {
        let everything = vec![format!("{ROOT}/**")];
        let mut rules = vec![
            json!({
                "id": "known", "permission": "allow", "flows": ["ingress", "egress"], "key_exprs": everything,
                "messages": [
                    "declare_subscriber", "declare_queryable", "query", "liveliness_query",
                    "declare_liveliness_subscriber",
                ],
            }),
            json!({
                "id": "answers", "permission": "allow", "flows": ["ingress", "egress"], "messages": ["reply"],
                "key_exprs": [format!("{ROOT}/may/**")],
            }),
        ];
        let (mut subjects, mut policies) = (Vec::new(), Vec::new());
        for member in &self.members {
            let name = &member.name;
            let mut own = vec!["known".to_owned(), "answers".to_owned()];
            for (flow, keys) in [("ingress", writes(member)), ("egress", reads(member))] {
                if keys.is_empty() {
                    continue;
                }
                let id = format!("{flow}-{name}");
                rules.push(json!({
                    "id": id, "permission": "allow", "flows": [flow], "key_exprs": keys,
                    "messages": ["put", "delete", "reply", "liveliness_token"],
                }));
                own.push(id);
            }
            subjects.push(json!({"id": name, "cert_common_names": [name]}));
            policies.push(json!({"rules": own, "subjects": [name]}));
        }
        json!({
            "enabled": true, "default_permission": "deny",
            "rules": rules, "subjects": subjects, "policies": policies,
        })
    }
}

/// Keys that a member may put something under.
fn writes(member: &Member) -> Vec<String> {
    let name = &member.name;
    if member.relays {
        return vec![format!("{ROOT}/**")];
    }
    let published = member.publishes.iter().flat_map(|finger| {
        ["contacts/**", "scans/**", "about", "echo/*", "alive/skin/*"]
            .map(|rest| format!("{ROOT}/{finger}/{rest}"))
    });
    let felt = member.feels.iter().flat_map(|finger| {
        ["wearers", "alive/wearer", "flexion"].map(|rest| format!("{ROOT}/{finger}/{rest}/{name}"))
    });
    published.chain(felt).collect()
}

/// Keys that a member may read.
fn reads(member: &Member) -> Vec<String> {
    let name = &member.name;
    if member.relays || member.watches {
        return vec![format!("{ROOT}/**")];
    }
    let published = member.publishes.iter().flat_map(|finger| {
        ["wearers/*", "flexion/*", "alive/**"].map(|rest| format!("{ROOT}/{finger}/{rest}"))
    });
    let felt = member.feels.iter().flat_map(|finger| {
        let own = format!("echo/{name}");
        ["contacts/**", "scans/**", "about", "alive/**", &own]
            .map(|rest| format!("{ROOT}/{finger}/{rest}"))
    });
    published.chain(felt).collect()
}

#[cfg(test)]
#[path = "access_tests.rs"]
mod tests;
