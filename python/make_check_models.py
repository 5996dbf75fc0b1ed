"""Writes the small ONNX models that the tests of `gen check` ask, into tests/models or the folder that is named.

    python python/make_check_models.py [DIR]

Nothing in them is trained: each answers what a line of arithmetic says, so that the tests can say it too. Needs onnx and
numpy; the bytes are the same in every run.
"""

import sys
from pathlib import Path

import numpy as np
from onnx import TensorProto, checker, external_data_helper, helper, numpy_helper

# As old as they can be, so that every onnxruntime from 1.17 on reads them.
OPSET, IR = 13, 8


def number(name, value):
    return numpy_helper.from_array(np.asarray(value), name)


def tensor(name, shape, kind=TensorProto.FLOAT):
    return helper.make_tensor_value_info(name, kind, shape)


def model(name, nodes, inputs, outputs, numbers):
    graph = helper.make_graph(nodes, name, inputs, outputs, initializer=numbers)
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR)
    made.producer_name = "sheetlight"
    # Files of weights are not there yet.
    if not any(each.external_data for each in numbers):
        checker.check_model(made, full_check=True)
    return made.SerializeToString(deterministic=True)


def mean_sign(shape, weights=None):
    """Two classes by the sign of the mean m of all that comes in: logits 4 m and -4 m; with `weights` those two numbers lie in
    the file of that name."""
    nodes = [
        helper.make_node("ReduceMean", ["x"], ["m"], axes=[1, 2, 3], keepdims=0),
        helper.make_node("Unsqueeze", ["m", "last"], ["column"]),
        helper.make_node("MatMul", ["column", "weights"], ["y"]),
    ]
    numbers = [number("last", np.int64([1])), number("weights", np.float32([[4, -4]]))]
    if weights:
        external_data_helper.set_external_data(numbers[1], weights)
        numbers[1].ClearField("raw_data")
    return model("mean_sign", nodes, [tensor("x", shape)], [tensor("y", [shape[0], 2])], numbers)


def pixel_sign():
    """Two classes of each pixel by the sign of its first channel c: logits c and -c."""
    nodes = [helper.make_node("Conv", ["x", "weights"], ["y"], kernel_shape=[1, 1])]
    numbers = [number("weights", np.float32([[[[1]]], [[[-1]]]]))]
    shape = ["n", 1, "rows", "cols"]
    return model("pixel_sign", nodes, [tensor("x", shape)], [tensor("y", ["n", 2, "rows", "cols"])], numbers)


def two_outputs():
    """Channels last, two channels a and b: probabilities by softmax of the means of a and b, and the class as number."""
    nodes = [
        helper.make_node("ReduceMean", ["x"], ["means"], axes=[1, 2], keepdims=0),
        helper.make_node("Softmax", ["means"], ["scores"], axis=1),
        helper.make_node("ArgMax", ["scores"], ["label"], axis=1, keepdims=0),
    ]
    outputs = [tensor("label", ["n"], TensorProto.INT64), tensor("scores", ["n", 2])]
    return model("two_outputs", nodes, [tensor("x", ["n", "rows", "cols", 2])], outputs, [])


def not_a_number():
    """Two classes by logarithms of the mean m: log m and log -m, one of which is no number."""
    nodes = [
        helper.make_node("ReduceMean", ["x"], ["m"], axes=[1, 2, 3], keepdims=0),
        helper.make_node("Unsqueeze", ["m", "last"], ["column"]),
        helper.make_node("MatMul", ["column", "weights"], ["both"]),
        helper.make_node("Log", ["both"], ["y"]),
    ]
    numbers = [number("last", np.int64([1])), number("weights", np.float32([[1, -1]]))]
    return model("not_a_number", nodes, [tensor("x", ["n", 1, "rows", "cols"])], [tensor("y", ["n", 2])], numbers)


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent.parent / "tests" / "models"
    free = mean_sign(["n", 1, "rows", "cols"])
    made = {
        "mean_sign.onnx": free,
        # Takes four at once of 8 x 8 pixels, as many exporters fix it.
        "fixed.onnx": mean_sign([4, 1, 8, 8]),
        # Keeps its weights in a file of their own, as exporters of large models do.
        "external.onnx": mean_sign(["n", 1, "rows", "cols"], "external.data"),
        "external.data": np.float32([[4, -4]]).tobytes(),
        "pixel_sign.onnx": pixel_sign(),
        "two_outputs.onnx": two_outputs(),
        "not_a_number.onnx": not_a_number(),
        # A copy that broke off.
        "truncated.onnx": free[: len(free) * 2 // 3],
    }
    for name, content in made.items():
        (folder / name).write_bytes(content)
        print(f"{name}: {len(content)} bytes")


if __name__ == "__main__":
    main()
