"""Imports random networks from Keras and in PyTorch's layout, has `hil` accept them (it refuses a model that misses its
golden vector), and holds ONNX Runtime on what `hil texture export` writes against the golden vector, to 1e-5.

    python check.py HIL
"""

import os
import pathlib
import subprocess
import sys
import tempfile

os.environ["KERAS_BACKEND"] = "jax"

import keras
import numpy as np
import onnxruntime
from safetensors.numpy import load_file, save_file

HERE = pathlib.Path(__file__).parent
SIZES = [(45, [96, 96, 96, 3]), (16, [20, 7, 12, 5])]


def by_keras(folder, features, units):
    layers = [keras.layers.GRU(u, return_sequences=i < 3, bias_initializer="random_uniform") for i, u in enumerate(units)]
    model = keras.Sequential([keras.Input((100, features)), *layers])
    path = folder / "model.keras"
    model.save(path)
    return "keras", path


def by_torch(folder, features, units):
    draw = np.random.default_rng(2)
    state = {}
    for i, (inputs, u) in enumerate(zip([features, *units], units)):
        shapes = {"weight_ih": (3 * u, inputs), "weight_hh": (3 * u, u), "bias_ih": (3 * u,), "bias_hh": (3 * u,)}
        for name, shape in shapes.items():
            state[f"encoder.{i}.{name}_l0"] = draw.uniform(-1, 1, shape).astype(np.float32) / np.float32(np.sqrt(u))
    path = folder / "state.safetensors"
    save_file(state, path)
    return "torch", path


def main(hil):
    for features, units in SIZES:
        for make in (by_keras, by_torch):
            with tempfile.TemporaryDirectory() as folder:
                folder = pathlib.Path(folder)
                kind, source = make(folder, features, units)
                lines = [f"f{i},{20000 + 10 * i},{40000 + 7 * i}" for i in range(features)]
                (folder / "scale.csv").write_text("feature,min,max\n" + "\n".join(lines) + "\n")
                model, onnx = folder / "model.safetensors", folder / "model.onnx"
                script = [sys.executable, HERE / "import.py", kind, source, model, "--scale", folder / "scale.csv"]
                subprocess.run(script, check=True)
                subprocess.run([hil, "texture", "export", model, "--out", onnx], check=True)
                tensors = load_file(model)
                session = onnxruntime.InferenceSession(onnx, providers=["CPUExecutionProvider"])
                found = session.run(None, {"raw": tensors["golden.window"][:, None, :]})[0][0]
                error = float(np.abs(found - tensors["golden.latent"]).max())
                print(f"{kind}, {features} features, units {units}: ONNX Runtime is {error:.1e} off")
                if not error <= 1e-5:
                    raise SystemExit(1)


main(sys.argv[1])
