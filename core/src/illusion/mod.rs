//! Sensor-to-display map, phantom models, onset timing (thesis chapter 5).
