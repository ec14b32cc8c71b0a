//! Device of a training: the processor, or a graphics card in a build that knows them.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// A kind of device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Device {
    /// One core of the processor, through the fused layer.
    #[default]
    Cpu,
    /// The graphics card that Vulkan (on macOS, Metal) calls the fastest; needs a build with `--features gpu`.
    Gpu,
}

impl Device {
    /// Name of the device. The error tells what is missing: the framework itself panics where there is no card.
    pub fn name(self) -> Result<String, Failure> {
        match self {
            Self::Cpu => Ok("the processor".into()),
            #[cfg(feature = "gpu")]
            Self::Gpu => card(),
            #[cfg(not(feature = "gpu"))]
            Self::Gpu => Err(Self::not_built()),
        }
    }

    /// There is no graphics card's backend in this program.
    #[cfg(not(feature = "gpu"))]
    pub fn not_built() -> Failure {
        Failure::Usage(
            "--device gpu: expected a program built with the backend of graphics cards: build it with \
             `cargo build --release -p palpate-train --features gpu`, or train with --device cpu"
                .into(),
        )
    }
}

/// The card that the framework will take: asked for as it does.
#[cfg(feature = "gpu")]
fn card() -> Result<String, Failure> {
    use burn_wgpu::graphics::{AutoGraphicsApi, GraphicsApi};
    use wgpu::{DeviceType, Instance, InstanceDescriptor, PowerPreference, RequestAdapterOptions};

    let instance = Instance::new(InstanceDescriptor {
        backends: AutoGraphicsApi::backend().into(),
        ..InstanceDescriptor::new_without_display_handle()
    });
    let asked = instance.request_adapter(&RequestAdapterOptions {
        power_preference: PowerPreference::HighPerformance,
        ..RequestAdapterOptions::default()
    });
    // outside a browser the answer is there at once
    let adapter = burn::tensor::read_sync(asked).map_err(|_| {
        Failure::Usage(
            "--device gpu: expected a graphics card with a Vulkan driver, found none: install its driver, which \
             `vulkaninfo` should then list, or train with --device cpu"
                .into(),
        )
    })?;
    let about = adapter.get_info();
    let kind = match about.device_type {
        DeviceType::Cpu => "a card in software, on the processor",
        _ => "a graphics card",
    };
    Ok(format!("{} ({}), {kind}", about.name, about.backend))
}

#[cfg(test)]
#[path = "device_tests.rs"]
pub mod tests;
