//! Checkpoints: everything a training run needs to go on as if it had never stopped.

use std::collections::HashMap;
use std::path::Path;

use burn::module::Module;
use burn::optim::Optimizer;
use burn::record::{BinBytesRecorder, FullPrecisionSettings, PrecisionSettings, Record, Recorder};
use burn::tensor::backend::Backend;
use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView};
use serde_json::json;

use crate::failure::{Failure, write};
use crate::gru::Learning;
use crate::network::Network;
use crate::settings::{Progress, Settings};

/// State of a training run.
pub struct State<L: Learning, O> {
    pub network: Network<L>,
    pub adam: O,
    /// The network of the best epoch.
    pub best: Network<L::InnerBackend>,
    pub progress: Progress,
}

/// An error without a file; the caller adds the file's name.
type Bad = Box<dyn std::error::Error>;

fn pack_as<S: PrecisionSettings, B: Backend, R: Record<B>>(record: R) -> Result<Vec<u8>, Bad> {
    let recorder = BinBytesRecorder::<S>::default();
    Ok(Recorder::<B>::record(&recorder, record, ())?)
}

fn unpack_as<S: PrecisionSettings, B: Backend, R: Record<B>>(
    bytes: &[u8],
    device: &B::Device,
) -> Result<R, Bad> {
    let recorder = BinBytesRecorder::<S>::default();
    Ok(Recorder::<B>::load(&recorder, bytes.to_vec(), device)?)
}

fn pack<B: Backend, R: Record<B>>(record: R) -> Result<Vec<u8>, Bad> {
    pack_as::<FullPrecisionSettings, B, R>(record)
}

fn unpack<B: Backend, R: Record<B>>(bytes: &[u8], device: &B::Device) -> Result<R, Bad> {
    unpack_as::<FullPrecisionSettings, B, R>(bytes, device)
}

/// A network's weights in a network of the same shape on another backend, in this precision.
pub fn carried<A: Backend, B: Backend, S: PrecisionSettings>(
    from: Network<A>,
    to: Network<B>,
) -> Result<Network<B>, Failure> {
    let bytes = pack_as::<S, A, _>(from.into_record());
    let record = bytes.and_then(|bytes| unpack_as::<S, B, _>(&bytes, &B::Device::default()));
    let record = record.map_err(|e| Failure::Usage(format!("the trained network: {e}")))?;
    Ok(to.load_record(record))
}

impl<L: Learning, O: Optimizer<Network<L>, L>> State<L, O> {
    /// Writes a checkpoint, whole or not at all.
    pub fn write(&self, path: &Path, settings: &Settings) -> Result<(), Failure> {
        let bytes = self.to_bytes(settings);
        write(path, &bytes.map_err(|e| Failure::file(path, e))?)
    }

    fn to_bytes(&self, settings: &Settings) -> Result<Vec<u8>, Bad> {
        let (network, best) = (self.network.clone(), self.best.clone());
        let parts = [
            ("network", pack::<L, _>(network.into_record())?),
            ("adam", pack::<L, _>(self.adam.to_record())?),
            ("best", pack::<L::InnerBackend, _>(best.into_record())?),
        ];
        let mut views = Vec::new();
        for (name, bytes) in &parts {
            let view = TensorView::new(Dtype::U8, vec![bytes.len()], bytes)?;
            views.push((*name, view));
        }
        let (settings, progress) = (json!(settings), json!(self.progress));
        let about = HashMap::from([
            ("settings".to_owned(), settings.to_string()),
            ("progress".to_owned(), progress.to_string()),
        ]);
        Ok(safetensors::serialize(views, Some(about))?)
    }

    /// The state that a checkpoint of these settings holds, in place of this one.
    pub fn read(
        self,
        path: &Path,
        settings: &Settings,
        device: &L::Device,
    ) -> Result<Self, Failure> {
        let bytes = std::fs::read(path).map_err(|e| Failure::file(path, e))?;
        let restored = self.restored(&bytes, settings, device);
        restored.map_err(|e| Failure::file(path, e))
    }

    fn restored(self, bytes: &[u8], settings: &Settings, device: &L::Device) -> Result<Self, Bad> {
        let (_, header) = SafeTensors::read_metadata(bytes)?;
        let about = header.metadata().clone().unwrap_or_default();
        let entry = |key: &str| about.get(key).map_or("", String::as_str);
        let written: Settings = serde_json::from_str(entry("settings"))?;
        // The length of the training may change, and with it the fall of the rate; nothing else may.
        let same = Settings {
            epochs: written.epochs,
            patience: written.patience,
            ..settings.clone()
        };
        if written != same {
            let what =
                "a checkpoint of other settings: give those, another --checkpoint, or remove it";
            return Err(what.into());
        }
        let file = SafeTensors::deserialize(bytes)?;
        let (network, adam) = (file.tensor("network")?, file.tensor("adam")?);
        let best = unpack::<L::InnerBackend, _>(file.tensor("best")?.data(), device)?;
        Ok(Self {
            network: (self.network).load_record(unpack::<L, _>(network.data(), device)?),
            adam: (self.adam).load_record(unpack::<L, _>(adam.data(), device)?),
            best: self.best.load_record(best),
            progress: serde_json::from_str(entry("progress"))?,
        })
    }
}
