"""Weights of a GRU encoder trained elsewhere as a model file for `hil texture`.

    python import.py keras MODEL.keras --scale SCALE.csv OUT.safetensors
    python import.py torch STATE.safetensors|STATE.pt --scale SCALE.csv OUT.safetensors

SCALE.csv: header `feature,min,max`, a line for each feature in the network's order. The encoder is the first GRU layers
of the model, `--layers` of them (4), of which the last one's final state is the latent vector.

keras: layers `GRU` with `reset_after=True` (the default). Keras keeps [inputs, 3 units] with the gates z, r, h; the
       golden vector is what Keras itself computes.
torch: a state dict of `nn.GRU` modules, one layer each, in their order (keys ending in `weight_ih_l0` and so on);
       rows r, z, n, as in our file. The golden vector is computed here, in f64, by the equations of PyTorch's manual.
"""

import argparse
import csv
import json
import os

os.environ.setdefault("KERAS_BACKEND", "jax")

import numpy as np
from safetensors.numpy import load_file, save_file

WINDOW = 100
TENSORS = ["weight_ih", "weight_hh", "bias_ih", "bias_hh"]


def from_keras(path, count):
    """Layers as {tensor: array}, and what computes latents of scaled windows [sample][feature]."""
    import keras

    layers = []

    def walk(layer):
        for inner in getattr(layer, "layers", []):
            if isinstance(inner, keras.layers.GRU):
                layers.append(inner)
            else:
                walk(inner)

    walk(keras.saving.load_model(path, compile=False))
    if len(layers) < count:
        raise SystemExit(f"{path}: expected at least {count} GRU layers, found {len(layers)}")
    layers = layers[:count]

    def rows(columns, units):  # z, r, h side by side -> r, z, n below each other
        z, r, h = columns[..., :units], columns[..., units : 2 * units], columns[..., 2 * units :]
        return np.ascontiguousarray(np.concatenate([r, z, h], axis=-1).T)

    converted = []
    for layer in layers:
        if not layer.reset_after:
            raise SystemExit(f"{path}: {layer.name}: expected reset_after=True, found False: another network")
        kernel, recurrent, bias = [np.asarray(w) for w in layer.get_weights()]
        tensors = [rows(a, layer.units) for a in (kernel, recurrent, bias[0], bias[1])]
        converted.append(dict(zip(TENSORS, tensors)))

    def latent(window):
        sequence = window[None].astype(np.float32)
        for layer in layers:
            cells = keras.layers.GRU.from_config({**layer.get_config(), "return_sequences": True})
            cells.build(sequence.shape)
            cells.set_weights(layer.get_weights())
            sequence = np.asarray(cells(sequence))
        return sequence[0, -1]

    return converted, latent


def from_torch(path, count):
    if str(path).endswith(".safetensors"):
        state = load_file(path)
    else:
        import torch

        state = {k: v.numpy() for k, v in torch.load(path, map_location="cpu", weights_only=True).items()}
    places = [k.split("weight_ih_l") for k in state if "weight_ih_l" in k and "reverse" not in k]
    if len(places) < count:
        raise SystemExit(f"{path}: expected at least {count} GRU layers, found {len(places)}")
    layers = [{t: state[f"{p}{t}_l{n}"] for t in TENSORS} for p, n in places[:count]]
    return layers, lambda window: by_the_manual(layers, window)


def by_the_manual(layers, window):
    """torch.nn.GRU, in f64."""
    logistic = lambda v: 1 / (1 + np.exp(-v))
    sequence = window.astype(np.float64)
    for layer in layers:
        w, u, b, c = [layer[t].astype(np.float64) for t in TENSORS]
        units = u.shape[1]
        h, out = np.zeros(units), []
        for x in sequence:
            (xr, xz, xn), (hr, hz, hn) = (w @ x + b).reshape(3, units), (u @ h + c).reshape(3, units)
            r, z = logistic(xr + hr), logistic(xz + hz)
            n = np.tanh(xn + r * hn)
            h = (1 - z) * n + z * h
            out.append(h)
        sequence = np.array(out)
    return sequence[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=["keras", "torch"])
    parser.add_argument("model")
    parser.add_argument("out")
    parser.add_argument("--scale", required=True)
    parser.add_argument("--layers", type=int, default=4)
    args = parser.parse_args()
    with open(args.scale, newline="") as file:
        features = list(csv.DictReader(file))
    low, high = (np.array([float(f[k]) for f in features], dtype=np.float32) for k in ("min", "max"))
    layers, latent = {"keras": from_keras, "torch": from_torch}[args.kind](args.model, args.layers)
    inputs = layers[0]["weight_ih"].shape[1]
    if inputs != len(features):
        raise SystemExit(f"{args.scale}: expected {inputs} features, as the first layer takes, found {len(features)}")

    # Any window will do as long as every part of the network matters to it.
    window = np.random.default_rng(1).uniform(low, high, (WINDOW, inputs)).astype(np.float32)
    span = np.where(high > low, high - low, np.inf)
    tensors = {"scale.min": low, "scale.max": high, "golden.window": window}
    tensors["golden.latent"] = np.asarray(latent((window - window[0]) / span), dtype=np.float32)
    for l, layer in enumerate(layers):
        tensors.update({f"encoder.{l}.{t}": np.ascontiguousarray(a, dtype=np.float32) for t, a in layer.items()})
    about = {"format": "palpate-texture 1", "window": str(WINDOW), "imported": f"{args.kind} {os.path.basename(args.model)}"}
    about["features"] = json.dumps([f["feature"] for f in features])
    save_file(tensors, args.out, metadata=about)


main()
