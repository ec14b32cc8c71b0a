//! Checkpoints: everything a training run needs to go on as if it had never stopped.

use std::collections::HashMap;
use std::path::Path;

use burn::module::Module;
use burn::optim::Optimizer;
use burn::record::{BinBytesRecorder, FullPrecisionSettings, Record, Recorder};
use burn::tensor::backend::Backend;
use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView};

use crate::device::Learning;
use crate::failure::Failure;
use crate::network::Network;
use crate::training::{Progress, Settings};

type Bytes = BinBytesRecorder<FullPrecisionSettings>;

fn pack<B: Backend, R: Record<B>>(record: R, path: &Path) -> Result<Vec<u8>, Failure> {
    Recorder::<B>::record(&Bytes::default(), record, ()).map_err(|e| Failure::file(path, e))
}

fn unpack<B: Backend, R: Record<B>>(
    bytes: &[u8],
    device: &B::Device,
    path: &Path,
) -> Result<R, Failure> {
    Recorder::<B>::load(&Bytes::default(), bytes.to_vec(), device)
        .map_err(|e| Failure::file(path, e))
}

/// Writes a checkpoint, whole or not at all.
pub fn write<L: Learning, O: Optimizer<Network<L>, L>>(
    path: &Path,
    settings: &Settings,
    network: &Network<L>,
    adam: &O,
    best: &Network<L::InnerBackend>,
    progress: &Progress,
) -> Result<(), Failure> {
    let parts = [
        (
            "network",
            pack::<L, _>(network.clone().into_record(), path)?,
        ),
        ("adam", pack::<L, _>(adam.to_record(), path)?),
        (
            "best",
            pack::<L::InnerBackend, _>(best.clone().into_record(), path)?,
        ),
    ];
    let mut views = Vec::new();
    for (name, bytes) in &parts {
        let view = TensorView::new(Dtype::U8, vec![bytes.len()], bytes)
            .map_err(|e| Failure::file(path, e))?;
        views.push((*name, view));
    }
    let text = |value: serde_json::Result<String>| value.map_err(|e| Failure::file(path, e));
    let about = HashMap::from([
        (
            "settings".to_owned(),
            text(serde_json::to_string(settings))?,
        ),
        (
            "progress".to_owned(),
            text(serde_json::to_string(progress))?,
        ),
    ]);
    let bytes = safetensors::serialize(views, Some(about)).map_err(|e| Failure::file(path, e))?;
    let partial = path.with_extension("partial");
    std::fs::write(&partial, bytes)
        .and_then(|()| std::fs::rename(&partial, path))
        .map_err(|e| Failure::file(path, e))
}

/// What [`write`] wrote.
#[allow(clippy::type_complexity)] // the four things a run consists of, used once
pub fn read<L: Learning, O: Optimizer<Network<L>, L>>(
    path: &Path,
    settings: &Settings,
    network: Network<L>,
    adam: O,
    best: Network<L::InnerBackend>,
    device: &L::Device,
) -> Result<(Network<L>, O, Network<L::InnerBackend>, Progress), Failure> {
    let bad = |what: &dyn ToString| Failure::file(path, what.to_string());
    let bytes = std::fs::read(path).map_err(|e| bad(&e))?;
    let (_, header) = SafeTensors::read_metadata(&bytes).map_err(|e| bad(&e))?;
    let about = header.metadata().clone().unwrap_or_default();
    let entry = |key: &str| about.get(key).map_or("", String::as_str);
    let written: Settings = serde_json::from_str(entry("settings")).map_err(|e| bad(&e))?;
    // How long to go on may change, and with it how fast the rate falls; nothing else.
    let same = Settings {
        epochs: written.epochs,
        patience: written.patience,
        ..settings.clone()
    };
    if written != same {
        return Err(bad(
            &"a checkpoint of other settings: give those, another --checkpoint, or remove it",
        ));
    }
    let progress = serde_json::from_str(entry("progress")).map_err(|e| bad(&e))?;
    let file = SafeTensors::deserialize(&bytes).map_err(|e| bad(&e))?;
    let part = |name: &str| {
        file.tensor(name)
            .map(|t| t.data().to_vec())
            .map_err(|e| bad(&e))
    };
    let network = network.load_record(unpack::<L, _>(&part("network")?, device, path)?);
    let adam = adam.load_record(unpack::<L, _>(&part("adam")?, device, path)?);
    let best = best.load_record(unpack::<L::InnerBackend, _>(&part("best")?, device, path)?);
    Ok((network, adam, best, progress))
}
