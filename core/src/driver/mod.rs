//! The PCA9685 driver.
