//! Layouts, frames, the initialiser and taxel health.
