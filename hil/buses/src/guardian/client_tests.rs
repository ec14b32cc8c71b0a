//! Tests of `client.rs`.

use super::*;

#[test]
fn the_first_process_of_a_namespace_and_those_in_one_have_no_guardian_that_outlives_them() {
    let status = |ids: &str| format!("Name:\thil\nNSpid:\t{ids}\nThreads:\t1\n");
    assert_eq!(dies_along(4711, &status("4711")), None);
    assert_eq!(dies_along(4711, ""), None, "an old kernel");
    for (pid, ids) in [(1, "1"), (4711, "4711\t1"), (12, "4711\t12")] {
        let why = dies_along(pid, &status(ids)).unwrap();
        assert!(why.contains("--init") && why.contains("real.oe"), "{why}");
    }
}
