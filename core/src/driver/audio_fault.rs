//! Faults of a sound card, and plans of its channels that cannot be.

/// Reasons for which a sound card cannot have these channels and levels.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AudioPlanError {
    /// A card without samples.
    #[error("a sample rate of 0 Hz, expected at least four samples for each period of the sine")]
    NoRate,
    /// A sine that the rate cannot follow, Hz, and the rate.
    #[error("a sine of {0} Hz at {1} samples per second, expected above 0 and at most {most} Hz", most = .1 / 4)]
    Sine(f64, u32),
    /// A highest level that is not a part of full scale.
    #[error(
        "a highest level of {0} times full scale, expected above 0 and at most 1; raise the full scale or lower the level"
    )]
    Level(f64),
    /// More actuators than an update has channels, or none.
    #[error("{0} actuators, expected 1 to 16")]
    Count(usize),
    /// Two actuators on one channel of the card.
    #[error(
        "actuator {0}: channel {1} of the card is used twice; give each actuator a channel of its own"
    )]
    ChannelTwice(u8, u8),
    /// A channel beyond those that a frame may have.
    #[error("actuator {0}: channel {1} of the card, expected 0 to 31")]
    NoChannel(u8, u8),
}

/// Fault of a sound card.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AudioFault {
    /// The card ran out of samples, and is silent.
    #[error(
        "sound card: it ran out of samples and went silent; nothing else may load this computer"
    )]
    Underrun,
    /// The card takes no more samples.
    #[error(
        "sound card: it takes no more samples; check its cable and that no other program holds it"
    )]
    Full,
}
