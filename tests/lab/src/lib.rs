//! Nothing but the suite beside it, which needs device nodes: `ci/lab-suite` runs it in the virtual lab.
