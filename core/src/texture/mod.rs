//! Texture: from a second of raw taxels to a place in a small latent space.
//!
//! The encoder is the first half of the GRU autoencoder of thesis Table 3.1 (features -> 96 -> 96 -> 96 -> 3, the
//! last state of the last layer is z), run exactly: every window of 100 samples starts from a state of zero and is
//! taken less its own first sample. [`Encoder`] is the network, [`Encoder::encode`] one window, [`Stream`] windows
//! one sample apart.
//!
//! [`ControlMap`] makes control parameters of z, (3.2); [`Pulses`] pulses of those, (3.1).
//!
//! z is the same bits with wide vectors and without: every sum is one chain of fused multiply-adds in the
//! order of its inputs, whatever is computed beside it.

mod control;
mod encoder;
mod fused;
mod gates;
mod kernel;
mod model;
mod pack;
mod pulses;
mod stream;

pub use control::{Control, ControlError, ControlMap, Drivers, LatentDriver, Span};
pub use encoder::{Encoder, Room};
pub use model::{Gru, Model, ModelError, SampleError, TensorPlace};
pub use pulses::{Activation, ActivationError, Draw, Pulses, along};
pub use stream::{Ends, Stream};
