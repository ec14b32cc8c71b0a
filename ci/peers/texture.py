"""The exported texture encoder in ONNX Runtime, one thread, on windows from standard input.

In: {model: path of the ONNX file, windows: a list of windows [sample][feature] of raw counts}. Out: {version,
window_us: median of one window at a time, batch_us: median for each window of a batch of all, latents}.
"""

import json
import statistics
import sys
import time

import numpy as np
import onnxruntime

ROUNDS = 200


def main():
    question = json.load(sys.stdin)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(question["model"], options, providers=["CPUExecutionProvider"])
    windows = np.asarray(question["windows"], dtype=np.float32)  # [window][sample][feature]
    single = [np.ascontiguousarray(w[:, None, :]) for w in windows]
    batch = np.ascontiguousarray(windows.transpose(1, 0, 2))
    run = lambda raw: session.run(["latent"], {"raw": raw})[0]

    def timed(raw):
        begun = time.perf_counter()
        run(raw)
        return (time.perf_counter() - begun) * 1e6

    latents = [run(raw)[0].tolist() for raw in single]
    json.dump(
        {
            "version": onnxruntime.__version__,
            "window_us": statistics.median(timed(single[i % len(single)]) for i in range(ROUNDS)),
            "batch_us": statistics.median(timed(batch) for _ in range(20)) / len(single),
            "latents": latents,
        },
        sys.stdout,
    )


main()
