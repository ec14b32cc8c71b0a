//! Where training runs: on the processor, or on a graphics card in a build that knows them.

use burn::tensor::backend::AutodiffBackend;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::gru::Recurrent;

/// A backend that learns: the layer with its gradient on it, the layer alone beneath it.
pub trait Learning: Recurrent + AutodiffBackend<InnerBackend: Recurrent> {}

impl<B: Recurrent + AutodiffBackend<InnerBackend: Recurrent>> Learning for B {}

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
    /// What it is called, or what is missing: the framework itself panics where there is no card.
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
pub mod tests {
    use super::*;

    /// Whether there is a card to test on; said so where there is none.
    #[cfg(feature = "gpu")]
    pub fn has_card() -> bool {
        match Device::Gpu.name() {
            Ok(name) => println!("on {name}"),
            Err(why) => {
                println!("skipped: {why}");
                return false;
            }
        }
        true
    }

    /// Two epochs, interrupted after the first.
    #[cfg(feature = "gpu")]
    #[test]
    fn training_on_a_card_goes_as_on_the_processor() {
        use crate::training::{Progress, Settings, tests, train};
        if !has_card() {
            return;
        }
        let (windows, split, ratings) = tests::small();
        let name = format!("palpate-train-card-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let run = |device, folder: Option<&std::path::Path>, more: fn(&Progress) -> bool| {
            let settings = Settings {
                device,
                share: 9,
                ..tests::settings(2)
            };
            train(&windows, &split, &ratings, &settings, folder, more).map(|(_, progress)| progress)
        };
        run(Device::Gpu, Some(&folder), |_| false).unwrap();
        let other = run(Device::Cpu, Some(&folder), |_| true).unwrap_err();
        assert!(other.to_string().contains("other settings"), "{other}");
        let gpu = run(Device::Gpu, Some(&folder), |_| true).unwrap();
        std::fs::remove_dir_all(folder).unwrap();
        let cpu = run(Device::Cpu, None, |_| true).unwrap();
        let errors = |of: &Progress| [of.train.clone(), of.validation.clone()].concat();
        let (cpu, gpu) = (errors(&cpu), errors(&gpu));
        println!("{cpu:?} {gpu:?}");
        assert_eq!((cpu.len(), gpu.len()), (4, 4));
        for (cpu, gpu) in cpu.iter().zip(&gpu) {
            assert!((cpu - gpu).abs() < 1e-4 * cpu, "{cpu} {gpu}");
        }
    }

    #[cfg(not(feature = "gpu"))]
    #[test]
    fn a_card_in_a_build_without_is_told_how_to_be_built() {
        let line = "cargo build --release -p palpate-train --features gpu";
        let why = Device::Gpu.name().unwrap_err().to_string();
        assert!(why.contains(line), "{why}");
    }

    #[test]
    fn settings_from_before_there_was_a_choice_are_of_the_processor() {
        use crate::training::{Settings, tests};
        let mut told = serde_json::to_value(tests::settings(1)).unwrap();
        assert_eq!(
            told.as_object_mut().unwrap().remove("device").unwrap(),
            "cpu"
        );
        let read: Settings = serde_json::from_value(told).unwrap();
        assert_eq!(read, tests::settings(1));
    }
}
