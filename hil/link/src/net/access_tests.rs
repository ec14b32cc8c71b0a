//! Tests of `access.rs`.

use super::*;

const LIST: &str = r#"
[[member]]
name = "r1"
publishes = ["r1/*/*"]

[[member]]
name = "w1"
feels = ["r1/left/index", "r2/*/*"]

[[member]]
name = "hub"
relays = true

[[member]]
name = "office"
watches = true
"#;

fn access(text: &str) -> Result<Access, String> {
    Access::read(Path::new("access.toml"), text)
}

#[test]
fn who_may_publish_is_said_by_the_list() {
    let access = access(LIST).unwrap();
    assert!(access.may_publish("r1", "r1/left/index"));
    for (name, finger) in [
        ("r1", "r2/left/index"),
        ("w1", "r1/left/index"),
        ("hub", "r1/left/index"),
        ("x", "r1/left/index"),
    ] {
        assert!(!access.may_publish(name, finger), "{name} {finger}");
    }
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let wrong = |text: &str, what: &str| {
        let said = access(text).unwrap_err();
        assert!(
            said.contains("access.toml") && said.contains(what),
            "{said}"
        );
    };
    wrong("[[member]]\nname = \"R 1\"", "member[0].name");
    wrong(
        "[[member]]\nname = \"a\"\n[[member]]\nname = \"a\"",
        "member[1].name",
    );
    wrong(
        "[[member]]\nname = \"a\"\npublishes = [\"**\"]",
        "ROBOT/HAND/FINGER",
    );
    wrong(
        "[[member]]\nname = \"a\"\npublish = [\"a/b/c\"]",
        "unknown field",
    );
    wrong("members", "line 1");
}

#[test]
fn rules_let_each_write_its_own_keys_and_read_what_it_feels() {
    let settings = access(LIST).unwrap().settings();
    assert_eq!(settings["default_permission"], "deny");
    let keys = |id: &str| -> Vec<String> {
        let rules = settings["rules"].as_array().unwrap();
        let rule = rules.iter().find(|r| r["id"] == id).unwrap();
        let keys = rule["key_exprs"].as_array().unwrap();
        keys.iter()
            .map(|k| k.as_str().unwrap().to_owned())
            .collect()
    };
    let written = keys("ingress-r1");
    assert!(written.contains(&"palpate/r1/*/*/contacts/**".to_owned()));
    assert!(!written.iter().any(|k| k.contains("wearers")));
    assert_eq!(
        keys("ingress-w1"),
        [
            "palpate/r1/left/index/wearers/w1",
            "palpate/r1/left/index/alive/wearer/w1",
            "palpate/r1/left/index/flexion/w1",
            "palpate/r2/*/*/wearers/w1",
            "palpate/r2/*/*/alive/wearer/w1",
            "palpate/r2/*/*/flexion/w1",
        ]
    );
    assert!(keys("egress-r1").contains(&"palpate/r1/*/*/flexion/*".to_owned()));
    assert!(keys("egress-w1").contains(&"palpate/r1/left/index/echo/w1".to_owned()));
    assert_eq!(keys("egress-office"), ["palpate/**"]);
    let rules = settings["rules"].as_array().unwrap();
    assert!(
        !rules.iter().any(|r| r["id"] == "ingress-office"),
        "a watcher writes nothing"
    );
}
