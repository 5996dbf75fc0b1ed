"""The network of train_baseline.py: three convolutions and a sum, its training, and its ONNX file with the sidecar."""

import json
import os

import onnx
import torch
from onnx import helper, numpy_helper


def scaling(patches, channels, logarithm):
    """What is taken off and divided by in each channel, in the sidecar's words: mean and standard deviation; of heights the
    median departure, which drops at the edge of a board do not widen. `log` has the same of the logarithm of light, for a
    network that takes it."""
    told = []
    for i, name in enumerate(channels):
        plane = patches.x[:, i].float()
        known = plane[~plane.isnan()].double()
        relative = name == "range"
        mean, sd = (0.0, 1.48 * known.abs().median().item()) if relative else (known.mean().item(), known.std().item())
        light = known.clamp(min=1).log()
        log = [light.mean().item(), max(light.std().item(), 1e-3)] if logarithm and not relative else None
        told.append({"name": name, "mean": round(mean, 3), "sd": round(max(sd, 1e-3), 4), "relative": relative, "log": log})
    return told


def normalised(x, told):
    """What the network takes: 0 where missing."""
    mean = torch.tensor([channel["mean"] for channel in told]).view(1, -1, 1, 1)
    sd = torch.tensor([channel["sd"] for channel in told]).view(1, -1, 1, 1)
    return torch.nan_to_num((x.float() - mean) / sd)


class Logarithm(torch.nn.Module):
    """Light by its logarithm, normalised anew, so that a longer exposure adds a constant to it; heights as they are.

    keep x + share (log(max(gain x + offset, 1)) - middle), each number of a channel."""

    def __init__(self, told):
        super().__init__()
        light = [channel["log"] for channel in told]
        rows = {"gain": [channel["sd"] if log else 0 for channel, log in zip(told, light)],
                "offset": [channel["mean"] if log else 1 for channel, log in zip(told, light)],
                "middle": [log[0] if log else 0 for log in light],
                "share": [1 / log[1] if log else 0 for log in light],
                "keep": [0 if log else 1 for log in light]}
        for name, row in rows.items():
            self.register_buffer(name, torch.tensor(row, dtype=torch.float32).view(1, -1, 1, 1))

    def forward(self, x):
        light = (x * self.gain + self.offset).clamp(min=1).log()
        return (light - self.middle) * self.share + x * self.keep


def network(told, classes, size):
    """Light by its logarithm, if the task wants it, outliers cut off, three convolutions, each halving rows and columns, and
    one sum for each class."""
    layers, planes = [torch.nn.Hardtanh(-6, 6)], len(told)
    if any(channel["log"] for channel in told):
        layers.insert(0, Logarithm(told))
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
    model = network(told, classes, patches.x.shape[2:])
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
        if isinstance(layer, Logarithm):
            least = keep("faint", torch.tensor(1.0))
            for step, (kind, *known) in enumerate([("Mul", "gain"), ("Add", "offset"), ("Clip",), ("Log",), ("Sub", "middle"),
                                                   ("Mul", "share")]):
                beside = [keep(name, getattr(layer, name)) for name in known] or ([least] if kind == "Clip" else [])
                nodes.append(helper.make_node(kind, [last, *beside], [f"light{step}"]))
                last = f"light{step}"
            nodes.append(helper.make_node("Mul", ["x", keep("keep", layer.keep)], ["heights"]))
            made = helper.make_node("Add", [last, "heights"], [f"y{i}"])
        elif isinstance(layer, torch.nn.Hardtanh):
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
    write_whole(path, made.SerializeToString(deterministic=True))


def write_sidecar(task, told, path, note, bits=8, trained_on=None):
    """The sidecar of a model that learned from digital numbers of so many bits; 8 is what none says. `trained_on` is the head of
    its dataset, by which `gen check` knows samples of the training again."""
    lines = [f"# {note}", f"task: {task.kind}", "channels:"]
    for channel in told:
        relative = ", relative: true" if channel["relative"] else ""
        lines.append(f"  - {{name: {channel['name']}, mean: {channel['mean']}, sd: {channel['sd']}{relative}}}")
    lines += [f"bits: {bits}"] if bits != 8 else []
    lines += [f"window_px: {list(task.window)}", f"size_px: {list(task.size)}",
              f"patches_per_class: {task.most}", "classes:"]
    lines += [f"  - {{name: {name}, of: [{', '.join(of)}]}}" for name, of in task.classes.items()]
    # Numbers of YAML are exact up to there.
    if trained_on is not None and trained_on["seed"] <= 2**53:
        recipe = trained_on["recipe"]
        drawn = {"family": recipe["canonical"]["family"], "seed": trained_on["seed"], "recipe_hash": recipe["hash"]}
        lines.append(f"trained_on: {json.dumps(drawn)}")
    write_whole(path, ("\n".join(lines) + "\n").encode())


def write_whole(path, content):
    """A file that is there as a whole or not at all."""
    part = path.with_name(f".tmp-{path.name}")
    part.write_bytes(content)
    os.replace(part, path)
