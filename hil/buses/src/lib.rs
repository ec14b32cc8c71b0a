//! Buses that the operating system gives: the ones a bench has, and the ones served to other programs.

pub mod can;
pub mod i2c;
pub mod pacer;
pub mod served;
pub mod sys;
