"""Throughput of `gen check` against a bare onnxruntime loop in Python: the same model, windows, batch and threads.

    python python/bench_onnx.py DIR [--gen target/release/gen] [--patches 2000] [--pairs 5] [--threads N]

Makes a convolutional network with random weights (four layers of 3 x 3, 32 to 256 channels, 64 x 64 pixels in, 60 million
multiplications a window; nothing is trained, the work is what counts), lets `gen check` run it over drawn pixels of DIR,
and runs as many windows from memory in a loop of session.run. Runs come in pairs, one after the other, because machines drift; the ratio of each pair and
their median are printed. `all` counts everything that gen does but loading the model: tables, decoding, cutting,
counting; `model` counts the time within onnxruntime.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

SIDE, CHANNELS = 64, 3


def network():
    """Convolutions that halve the sides, a mean and two classes."""
    rng = np.random.default_rng(0)
    nodes, numbers, source, width = [], [], "x", CHANNELS
    for i, wider in enumerate([32, 64, 128, 256]):
        weights = rng.normal(0, (2 / (9 * width)) ** 0.5, (wider, width, 3, 3)).astype(np.float32)
        numbers.append(numpy_helper.from_array(weights, f"w{i}"))
        stride = [1, 1] if i == 0 else [2, 2]
        nodes.append(helper.make_node("Conv", [source, f"w{i}"], [f"c{i}"], pads=[1, 1, 1, 1], strides=stride))
        nodes.append(helper.make_node("Relu", [f"c{i}"], [f"r{i}"]))
        source, width = f"r{i}", wider
    last = rng.normal(0, width**-0.5, (width, 2)).astype(np.float32)
    numbers.append(numpy_helper.from_array(last, "last"))
    nodes.append(helper.make_node("ReduceMean", [source], ["m"], axes=[2, 3], keepdims=0))
    nodes.append(helper.make_node("MatMul", ["m", "last"], ["y"]))
    image = helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n", CHANNELS, SIDE, SIDE])
    scores = helper.make_tensor_value_info("y", TensorProto.FLOAT, ["n", 2])
    graph = helper.make_graph(nodes, "network", [image], [scores], initializer=numbers)
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8).SerializeToString()


SIDECAR = """task: classify_pixels
channels: [{{name: range, relative: true}}, {{name: reflectance, mean: 100, sd: 50}}, {{name: scatter, mean: 600, sd: 300}}]
window_px: [{side}, {side}]
patches_per_class: {patches}
classes: [{first}, {{name: other, of: [{others}]}}]
"""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("dir", type=Path)
    parser.add_argument("--gen", default="target/release/gen")
    parser.add_argument("--patches", type=int, default=2000)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    asked = parser.parse_args()
    head = json.loads((asked.dir / "dataset.json").read_text())
    first, *others = [head["pixel_classes"][value] for value in head["label_values"][1:]]
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "network.onnx"
        model.write_bytes(network())
        values = dict(side=SIDE, patches=asked.patches // 2, first=first, others=", ".join(others))
        model.with_suffix(".yaml").write_text(SIDECAR.format(**values))
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = asked.threads
        command = [asked.gen, "check", asked.dir, "--model", model, "--split", "all", "--json", "--worst", "0"]
        command += ["--batch", str(asked.batch), "--threads", str(asked.threads)]

        def checked():
            """Windows a second of gen: in all, and within the model."""
            run = subprocess.run(list(map(str, command)), capture_output=True, text=True)
            if run.returncode:
                sys.exit(run.stderr)
            found = json.loads(run.stdout)
            count, timing = found["accuracy"]["of"], found["timing"]
            return count, count / timing["seconds"], count / timing["model_seconds"]

        def looped(count):
            """Windows a second of the loop."""
            session = onnxruntime.InferenceSession(str(model), options, providers=["CPUExecutionProvider"])
            batch = np.random.default_rng(1).normal(size=(asked.batch, CHANNELS, SIDE, SIDE)).astype(np.float32)
            start, done = time.perf_counter(), 0
            while done < count:
                n = min(asked.batch, count - done)
                session.run(None, {"x": batch[:n]})
                done += n
            return count / (time.perf_counter() - start)

        ratios = []
        for pair in range(asked.pairs):
            # Whoever comes second may find the machine warmer: take turns.
            if pair % 2:
                count, everything, inside = checked()
                loop = looped(count)
            else:
                loop = looped(ratios[-1][0] if ratios else asked.patches)
                count, everything, inside = checked()
            ratios.append((count, everything / loop, inside / loop))
            print(f"{count} windows: loop {loop:.0f}/s, gen {everything:.0f}/s ({everything / loop:.3f}), "
                  f"within the model {inside:.0f}/s ({inside / loop:.3f})")
        median = [statistics.median(column) for column in list(zip(*ratios))[1:]]
        print(f"median ratio, all: {median[0]:.3f}; model: {median[1]:.3f}")


if __name__ == "__main__":
    main()
