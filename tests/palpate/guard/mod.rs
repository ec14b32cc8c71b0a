//! The guard against the full model: its table, its predictions, and hostile schedules.

mod bounds;
mod counting;
mod hostile;
mod kernel;
mod latent;
mod rig;
mod schedule;
mod table;
