//! Buses that the operating system gives: those of a bench, and those served to other programs.

pub mod can;
pub mod datagrams;
mod desk;
pub mod guardian;
pub mod hardware;
pub mod i2c;
pub mod ledger;
pub mod lock;
pub mod oe;
pub mod pacer;
pub mod pulse;
pub mod served;
mod shared_file;
pub mod signals;
pub mod survey;
pub mod sys;
pub mod terminal;
pub mod uptime;
