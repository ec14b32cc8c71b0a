//! The sensor end: the counts that a touch makes of a module's taxels, the boards that send them, the CAN
//! segment between boards and host, and surfaces to stroke.

mod array;
pub mod board;
pub mod can;
mod mechanics;
mod module;
pub mod port;
pub mod rig;
pub mod surface;
mod transducer;

pub use array::{Delivery, SkinArray};
pub use mechanics::{Press, Silicone, Touches};
pub use module::{EmulatedModule, ModuleConfig, grid};
pub use transducer::{Generation, Transducer};
