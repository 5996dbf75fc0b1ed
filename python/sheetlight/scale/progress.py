"""One view of a run: a line that is renewed on a terminal, a line every half minute elsewhere."""

import sys
import time
from dataclasses import dataclass, field
from typing import TextIO

EVERY_S = {True: 0.5, False: 30.0}
"""Time between two lines [s], on a terminal and elsewhere."""


@dataclass
class Progress:
    """How far a run is."""

    url: str
    """Where the dataset lies."""
    shards: int
    """Shards of the dataset."""
    finished: int
    """Shards that are there, whoever made them."""
    made: int = 0
    """Shards that this run made."""
    samples: int = 0
    """Samples in them."""
    bytes: int = 0
    """Bytes in them."""
    failed: int = 0
    """Shards that this run gave up."""
    render_s: float = 0.0
    """Time in `gen`, summed over tasks [s]."""
    other_s: float = 0.0
    """Time of tasks before and after that, summed [s]."""
    begun: float = field(default_factory=time.monotonic)
    """When the run began, by the monotonic clock [s]."""

    def remaining_s(self) -> float | None:
        """Time that the remaining shards will take at the pace of this run [s]; None before the first one."""
        if not self.made:
            return None
        return (time.monotonic() - self.begun) / self.made * (self.shards - self.finished)

    def __str__(self) -> str:
        text = f"{self.url}: {self.finished} of {self.shards} shards"
        if self.made:
            text += f", {self.samples} samples in {self.made} shards made now, {self.bytes / 1e6:.0f} MB"
        if self.failed:
            text += f", {self.failed} failed"
        remaining = self.remaining_s()
        if remaining:
            text += f", {_duration(remaining)} left"
        return text


class ProgressLine:
    """Shows a run on a stream; called with its Progress each time that something changed."""

    def __init__(self, stream: TextIO | None = None):
        self.stream = stream or sys.stderr
        self.terminal = self.stream.isatty()
        self.shown = float("-inf")

    def __call__(self, progress: Progress) -> None:
        now = time.monotonic()
        is_last = progress.finished + progress.failed >= progress.shards
        if not is_last and now - self.shown < EVERY_S[self.terminal]:
            return
        self.shown = now
        if self.terminal:
            self.stream.write(f"\r\x1b[K{progress}" + ("\n" if is_last else ""))
        else:
            self.stream.write(f"{progress}\n")
        self.stream.flush()


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"
