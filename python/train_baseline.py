"""Trains a small network on patches of a dataset that `gen` made, and writes it as ONNX with the sidecar of `gen check`.

    python python/train_baseline.py out/wood --task wood --out knots.onnx
    python python/train_baseline.py out/packs --task presence --out tablets.onnx --channels scatter
    gen check out/other --model knots.onnx --split all

Tasks: `wood` (clear, knot or rot at the middle of a window), `blister` (pocket with tablet, empty, with a broken tablet)
and `presence` (pocket with a tablet or without). Windows are cut, shrunk and normalised exactly as `gen check` does
(docs/check.md). The same seed and number of threads give the same bytes on one machine.

Needs numpy, pyarrow, pillow, torch and onnx: `make venv` installs them. docs/baselines.md has the figures.
"""

import argparse
import sys
import time
from pathlib import Path

try:
    import onnx
    import torch
    from onnx import helper, numpy_helper

    from baseline_patches import CHANNELS, TASKS, cut_patches, read_head
except ImportError as missing:
    sys.exit(f"train_baseline.py needs the package `{missing.name}`: run `make venv` and use .venv/bin/python, "
             "or pip install -r python/requirements.txt")


def scaling(patches, channels):
    """What is taken off and divided by in each channel, in the sidecar's words: mean and standard deviation; of heights the
    median departure, which drops at the edge of a board do not widen."""
    told = []
    for i, name in enumerate(channels):
        plane = patches.x[:, i].float()
        known = plane[~plane.isnan()].double()
        relative = name == "range"
        mean, sd = (0.0, 1.48 * known.abs().median().item()) if relative else (known.mean().item(), known.std().item())
        told.append({"name": name, "mean": round(mean, 3), "sd": round(max(sd, 1e-3), 4), "relative": relative})
    return told


def normalised(x, told):
    """What the network takes: 0 where missing."""
    mean = torch.tensor([channel["mean"] for channel in told]).view(1, -1, 1, 1)
    sd = torch.tensor([channel["sd"] for channel in told]).view(1, -1, 1, 1)
    return torch.nan_to_num((x.float() - mean) / sd)


def network(channels, classes, size):
    """Outliers cut off, three convolutions, each halving rows and columns, and one sum for each class."""
    layers, planes = [torch.nn.Hardtanh(-6, 6)], channels
    for wider, kernel in ((16, 5), (32, 3), (64, 3)):
        layers += [torch.nn.Conv2d(planes, wider, kernel, stride=2, padding=kernel // 2, bias=False),
                   torch.nn.BatchNorm2d(wider), torch.nn.ReLU()]
        planes = wider
    return torch.nn.Sequential(*layers, torch.nn.Flatten(), torch.nn.Dropout(0.2),
                               torch.nn.Linear(planes * size[0] * size[1] // 64, classes))


def answers(model, x, told):
    """Logits [patches, classes]."""
    model.eval()
    with torch.no_grad():
        return torch.cat([model(normalised(part, told)) for part in x.split(512)])


def train(patches, told, classes, seed, epochs, shuffle=False, say=None):
    """A network trained on patches, each mirrored along the laser line or not; `say(epoch, loss, model)` after each epoch.

    With `shuffle` the labels are dealt out anew, so that there is nothing to learn.
    """
    torch.manual_seed(seed)
    labels = patches.y[torch.randperm(len(patches.y))] if shuffle else patches.y
    model = network(patches.x.shape[1], classes, patches.x.shape[2:])
    # A class that is rare counts as much as the others.
    weights = len(labels) / (classes * torch.bincount(labels, minlength=classes).clamp(min=1).float())
    steps = max(1, len(labels) // 128)
    optimiser = torch.optim.AdamW(model.parameters(), lr=4e-3, weight_decay=1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 4e-3, total_steps=epochs * steps, pct_start=0.2)
    for epoch in range(epochs):
        model.train()
        total = 0.0
        for batch in torch.randperm(len(labels))[:steps * 128].chunk(steps):
            x = normalised(patches.x[batch], told)
            mirror = torch.rand(len(batch)) < 0.5
            x[mirror] = x[mirror].flip(3)
            loss = torch.nn.functional.cross_entropy(model(x), labels[batch], weights)
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            schedule.step()
            total += loss.item()
        if say:
            say(epoch, total / steps, model)
    return model


def write_onnx(model, channels, task, path):
    """The network as an ONNX graph, written by hand: as old an operator set as can be, the same bytes in every run, and
    no exporter needed. Batch normalisation becomes part of the convolution before it."""
    layers, nodes, numbers, last = list(model.eval()), [], [], "x"

    def keep(name, tensor):
        numbers.append(numpy_helper.from_array(tensor.detach().float().numpy(), name))
        return name

    for i, layer in enumerate(layers):
        if isinstance(layer, torch.nn.Hardtanh):
            ends = [keep("least", torch.tensor(layer.min_val)), keep("most", torch.tensor(layer.max_val))]
            made = helper.make_node("Clip", [last, *ends], [f"y{i}"])
        elif isinstance(layer, torch.nn.Conv2d):
            norm = layers[i + 1]
            gain = norm.weight / torch.sqrt(norm.running_var + norm.eps)
            weight = keep(f"w{i}", layer.weight * gain.view(-1, 1, 1, 1))
            bias = keep(f"b{i}", norm.bias - norm.running_mean * gain)
            made = helper.make_node("Conv", [last, weight, bias], [f"y{i}"], kernel_shape=list(layer.kernel_size),
                                    strides=list(layer.stride), pads=2 * list(layer.padding))
        elif isinstance(layer, torch.nn.ReLU):
            made = helper.make_node("Relu", [last], [f"y{i}"])
        elif isinstance(layer, torch.nn.Flatten):
            made = helper.make_node("Flatten", [last], [f"y{i}"])
        elif isinstance(layer, torch.nn.Linear):
            names = [last, keep(f"w{i}", layer.weight), keep(f"b{i}", layer.bias)]
            made = helper.make_node("Gemm", names, ["logits"], transB=1)
        else:  # Batch normalisation is done, dropout is for training alone.
            continue
        nodes.append(made)
        last = made.output[0]
    shapes = [("x", ["n", channels, *task.size]), ("logits", ["n", len(task.classes)])]
    x, y = [helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, shape) for name, shape in shapes]
    graph = helper.make_graph(nodes, "baseline", [x], [y], initializer=numbers)
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8, producer_name="sheetlight")
    onnx.checker.check_model(made, full_check=True)
    path.write_bytes(made.SerializeToString(deterministic=True))


def write_sidecar(task, told, path, note):
    lines = [f"# {note}", f"task: {task.kind}", "channels:"]
    for channel in told:
        relative = ", relative: true" if channel["relative"] else ""
        lines.append(f"  - {{name: {channel['name']}, mean: {channel['mean']}, sd: {channel['sd']}{relative}}}")
    lines += [f"window_px: {list(task.window)}", f"size_px: {list(task.size)}",
              f"patches_per_class: {task.most}", "classes:"]
    lines += [f"  - {{name: {name}, of: [{', '.join(of)}]}}" for name, of in task.classes.items()]
    path.write_text("\n".join(lines) + "\n")


def arguments():
    summary, rest = __doc__.split("\n", 1)
    parser = argparse.ArgumentParser(description=summary, epilog=rest, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="DIR", help="a dataset with train and validation splits")
    parser.add_argument("--task", choices=TASKS, required=True, help="what to learn")
    parser.add_argument("--out", type=Path, required=True, metavar="MODEL.onnx", help="the sidecar becomes MODEL.yaml")
    parser.add_argument("--channels", default=",".join(CHANNELS), help="maps to look at (default: %(default)s)")
    parser.add_argument("--patches", type=int, default=8000, help="drawn pixels of each class (default: %(default)s)")
    parser.add_argument("--epochs", type=int, default=12, help="times that each patch is seen (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of weights, order and drawn pixels (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=1, help="threads to train with (default: %(default)s)")
    parser.add_argument("--shuffle-labels", action="store_true", help="control: deal the labels of training out anew")
    given = parser.parse_args()
    given.channels = given.channels.split(",")
    wrong = [name for name in given.channels if name not in CHANNELS]
    if wrong or len(set(given.channels)) < len(given.channels):
        parser.error(f"--channels takes some of {', '.join(CHANNELS)}, each once")
    if min(given.patches, given.epochs, given.threads) < 1:
        parser.error("--patches, --epochs and --threads are at least 1")
    if given.out.suffix != ".onnx" or not given.out.parent.is_dir():
        parser.error(f"--out {given.out}: give a name that ends in .onnx, in a folder that exists")
    return given


def main():
    given = arguments()
    torch.set_num_threads(given.threads)
    torch.use_deterministic_algorithms(True)
    task = TASKS[given.task]
    learn = cut_patches(given.folder, task, given.channels, "train", given.patches, given.seed)
    test = cut_patches(given.folder, task, given.channels, "validation", max(1, given.patches // 8), given.seed)
    told = scaling(learn, given.channels)
    print(f"{len(learn.y)} patches to learn from, {len(test.y)} to validate with", flush=True)
    began = time.monotonic()

    def say(epoch, loss, model):
        right = (answers(model, test.x, told).argmax(1) == test.y).sum().item()
        print(f"epoch {epoch + 1}/{given.epochs}: loss {loss:.4f}, validation {right}/{len(test.y)} = "
              f"{right / len(test.y):.4f}, {time.monotonic() - began:.0f} s", flush=True)

    model = train(learn, told, len(task.classes), given.seed, given.epochs, given.shuffle_labels, say)
    write_onnx(model, len(given.channels), task, given.out)
    recipe = read_head(given.folder)["recipe"]["name"]
    note = f"Task {given.task}, trained on {recipe} by python/train_baseline.py; labels shuffled: {given.shuffle_labels}."
    write_sidecar(task, told, given.out.with_suffix(".yaml"), note)
    print(f"{given.out}: {given.out.stat().st_size} bytes, {sum(p.numel() for p in model.parameters())} parameters")


if __name__ == "__main__":
    main()
