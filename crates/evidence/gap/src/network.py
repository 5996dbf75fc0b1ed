"""The classifier of `gen compare --gap`: small convolutional networks that tell windows of two sides apart.

`gen` writes the windows and which of them belong to which fold, starts this script with that folder, and reads back a
number for each window: how sure a network that never saw its fold is that it is of side 1. It needs numpy and torch, takes
the CPU alone, and gives the same numbers again with the same version of torch.

  job.json     side_px, channels (names in the order of the file, mask last), experiments: each with `window`, `label`
               (0 or 1) and `fold` of every window in it, and `folds`
  windows.f32  [windows, channels, side_px, side_px], little-endian: range [um or mpx], reflectance and scatter [DN],
               mask [0 or 1]
  scores.json  {"scores": [[..], ..]}, written last: in each experiment a number of each window [0 to 1]
"""

import json
import os
import sys
import threading
from pathlib import Path

SEED = 1
# One thread: steps are too small to be shared, and the same numbers come for any number of cores.
THREADS = 1
STEPS = 160
BATCH = 64
LEARNING_RATE = 3e-3
WEIGHT_DECAY = 1e-3
DROPOUT = 0.2
# Kernel of the local mean of heights that is taken out for their fine structure [px].
DETAIL_PX = 5
# Fine structure beyond so many deviations of the noise is an edge.
DETAIL_LIMIT = 4.0
# Exit statuses that `gen` knows.
NO_PACKAGE = 3


def end_with_parent():
    """Ends this process as soon as `gen`, which holds the other end of standard input, has ended."""

    def wait():
        # Not through sys.stdin, whose lock the interpreter wants when it ends.
        while os.read(0, 4096):
            pass
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


end_with_parent()
try:
    import numpy as np
    import torch
    from torch import nn
    from torch.nn import functional
except ImportError as error:
    print(error, file=sys.stderr)
    os._exit(NO_PACKAGE)


def features(maps, names):
    """What the network sees of each window, of order 1: heights and light, also as fine structure, and the mask."""
    mask = maps[:, names.index("mask")].unsqueeze(1)
    heights = maps[:, names.index("range")].unsqueeze(1)
    bends = (heights[..., 2:] - 2 * heights[..., 1:-1] + heights[..., :-2]).abs()
    known = (mask[..., 2:] * mask[..., 1:-1] * mask[..., :-2]) > 0
    # The median of |second differences| of normal noise of deviation s is 0.6745 sqrt(6) s. Of both sides together, without
    # labels.
    noise = max(float(bends[known].median()) / (0.6745 * 6**0.5), 1e-6) if bool(known.any()) else 1.0

    def local_mean(values):
        inside = functional.avg_pool2d(mask, DETAIL_PX, stride=1, padding=DETAIL_PX // 2).clamp_min(1e-6)
        return functional.avg_pool2d(values * mask, DETAIL_PX, stride=1, padding=DETAIL_PX // 2) / inside

    detail = ((heights - local_mean(heights)) / noise).clamp(-DETAIL_LIMIT, DETAIL_LIMIT) / 2
    seen = [torch.asinh(heights / noise) / 2 * mask, detail * mask]
    if "reflectance" in names:
        light = maps[:, names.index("reflectance")].unsqueeze(1)
        # Its local contrast beside its level: speckle multiplies.
        local = local_mean(light).clamp_min(1)
        seen += [(light / 127.5 - 1) * mask, ((light - local) / local).clamp(-1, 1) * 4 * mask]
    if "scatter" in names:
        scatter = torch.log1p(maps[:, names.index("scatter")].unsqueeze(1).clamp_min(0))
        centre = (scatter * mask).sum() / mask.sum().clamp_min(1)
        spread = (((scatter - centre) ** 2 * mask).sum() / mask.sum().clamp_min(1)).sqrt().clamp_min(1e-3)
        seen.append((scatter - centre) / spread * mask)
    return torch.cat([*seen, mask], dim=1).contiguous(memory_format=torch.channels_last)


def network(channels):
    """Three layers of 3 x 3 and a mean over the window: about eleven thousand weights."""
    layers = []
    for inputs, outputs, stride in [(channels, 16, 2), (16, 24, 1), (24, 32, 2)]:
        layers += [nn.Conv2d(inputs, outputs, 3, stride=stride, padding=1), nn.ReLU()]
    layers += [nn.AdaptiveAvgPool2d(1), nn.Flatten(), nn.Dropout(DROPOUT), nn.Linear(32, 1)]
    return nn.Sequential(*layers).to(memory_format=torch.channels_last)


def train(seen, label, seed):
    """A network that tells windows of label 1 from those of label 0; both sides weigh the same."""
    torch.manual_seed(seed)
    model = network(seen.shape[1])
    sides = [torch.nonzero(label == side).flatten() for side in (0, 1)]
    steps = torch.optim.AdamW(model.parameters(), lr=LEARNING_RATE, weight_decay=WEIGHT_DECAY)
    pace = torch.optim.lr_scheduler.OneCycleLR(steps, max_lr=LEARNING_RATE, total_steps=STEPS)
    target = torch.cat([torch.zeros(BATCH // 2), torch.ones(BATCH // 2)])
    model.train()
    for _ in range(STEPS):
        # Half of each batch from either side.
        chosen = torch.cat([side[torch.randint(len(side), (BATCH // 2,))] for side in sides])
        loss = functional.binary_cross_entropy_with_logits(model(seen[chosen]).flatten(), target)
        steps.zero_grad()
        loss.backward()
        steps.step()
        pace.step()
    return model.eval()


def scores(seen, experiment, number):
    """For each window of an experiment the answer of the network that was trained without its fold."""
    window, label, fold = (torch.tensor(experiment[key]) for key in ("window", "label", "fold"))
    answer = torch.full((len(window),), float("nan"))
    for held_out in range(experiment["folds"]):
        rest, held = fold != held_out, fold == held_out
        model = train(seen[window[rest]], label[rest], 1000 * SEED + 100 * number + held_out)
        with torch.no_grad():
            parts = [torch.sigmoid(model(part).flatten()) for part in seen[window[held]].split(512)]
        answer[held] = torch.cat(parts)
        print("fold", flush=True)
    return answer.tolist()


def main(folder):
    torch.use_deterministic_algorithms(True)
    torch.set_num_threads(THREADS)
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    side, names = job["side_px"], job["channels"]
    maps = np.fromfile(folder / "windows.f32", dtype="<f4").reshape(-1, len(names), side, side)
    seen = features(torch.from_numpy(maps), names)
    found = [scores(seen, experiment, number) for number, experiment in enumerate(job["experiments"])]
    unfinished = folder / "scores.tmp"
    unfinished.write_text(json.dumps({"scores": found, "torch": torch.__version__}), encoding="utf-8")
    unfinished.replace(folder / "scores.json")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
    # Threads of torch may outlive the interpreter: the work is done.
    sys.stdout.flush()
    os._exit(0)
