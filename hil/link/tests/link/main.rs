//! Tests of the link: the gate in virtual time, the felt path behind a network, two programs on loopback.

mod felt;
mod gate;
mod loopback;
mod weather;
