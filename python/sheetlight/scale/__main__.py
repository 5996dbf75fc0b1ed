"""`python -m sheetlight.scale`: what scripts of clusters call.

Exit status: 0 done; 1 try again; 2 trying again changes nothing; 130 and 143 stopped.
"""

import argparse
import contextlib
import json
import signal
import sys
from collections.abc import Callable
from typing import Any, NoReturn

from . import ScaleError, begin, finish, generate, make, status
from .engines import ENGINES


def main(arguments: list[str] | None = None) -> int:
    """Does what the arguments say and returns the exit status."""
    asked = _parser().parse_args(arguments)
    # As process 1 of a container Python would not end by itself.
    signal.signal(signal.SIGTERM, _terminate)
    try:
        return asked.does(asked)
    except ScaleError as fault:
        print(f"sheetlight.scale: {fault}", file=sys.stderr)
        return fault.status
    except KeyboardInterrupt:
        print("sheetlight.scale: stopped; finished shards are kept, the same command goes on", file=sys.stderr)
        return 130


def _terminate(number: int, _frame: Any) -> NoReturn:
    raise SystemExit(128 + number)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m sheetlight.scale",
        description="Datasets by many machines, into a folder or a bucket (s3://, gs://, az://, hf://buckets/).",
        epilog="Exit status: 0 done; 1 try again; 2 trying again changes nothing.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, does: Any, words: str) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=words, description=words)
        added.add_argument("url", metavar="URL", help="where the dataset lies")
        added.add_argument("--json", action="store_true", help="print the result as JSON")
        added.set_defaults(does=does)
        return added

    def recipe(added: argparse.ArgumentParser) -> None:
        added.add_argument("--recipe", required=True, help="a YAML file, or the name of a built-in recipe")
        added.add_argument("--n", type=int, required=True, help="samples of the whole dataset; a larger number extends it")
        added.add_argument("--seed", type=int, help="seed of all draws [that of the dataset, or 0]")
        added.add_argument("--samples-per-shard", type=int, help="samples of a shard [those of the dataset, or the recipe's]")
        added.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key")

    def scratch(added: argparse.ArgumentParser) -> None:
        added.add_argument("--scratch", help="folder for scratch folders [$SHEETLIGHT_SCRATCH, or the temporary folder]")

    def threads(added: argparse.ArgumentParser) -> None:
        added.add_argument("--threads", type=_whole(1), default=1, help="threads of a task [1]")

    added = command("begin", _begin, "Begin a dataset, or take up and extend the one that is there; renders nothing")
    recipe(added)
    scratch(added)
    added = command("task", _task, "Make the missing shards of a part of a dataset that was begun")
    added.add_argument("--part", type=_part, default=(0, 1), metavar="K/M", help="shards K, K+M, K+2M, ... [0/1]")
    threads(added)
    scratch(added)
    added = command("finish", _finish, "Check that all is there, and write card and metadata")
    scratch(added)
    command("status", _status, "Say how far it is; exit status 1 where shards are missing")
    added = command("generate", _generate, "All of it: begin, a task for each missing shard, finish")
    added.add_argument("--engine", choices=ENGINES, default="ray", help="what runs the tasks [ray]")
    added.add_argument("--retries", type=_whole(0), default=5, help="how often a task is repeated at most [5]")
    recipe(added)
    threads(added)
    scratch(added)
    return parser


def _begin(asked: argparse.Namespace) -> int:
    head = begin(asked.recipe, asked.n, asked.url, **_recipe(asked), scratch=asked.scratch)
    told = {key: head[key] for key in ("samples", "samples_per_shard", "shards", "seed")}
    return _tell(asked, told, f"{asked.url}: {told['samples']} samples in {told['shards']} shards")


def _task(asked: argparse.Namespace) -> int:
    made = make(asked.url, asked.part, threads=asked.threads, scratch=asked.scratch)
    k, m = asked.part
    return _tell(asked, made, f"{asked.url}: {sum(report['made'] for report in made)} shards made of part {k}/{m}")


def _finish(asked: argparse.Namespace) -> int:
    done = finish(asked.url, scratch=asked.scratch)
    return _tell(asked, done, f"{done['url']}: {done['samples']} samples in {done['shards']} shards, finished")


def _status(asked: argparse.Namespace) -> int:
    found = status(asked.url)
    missing = len(found["missing"])
    _tell(asked, found, f"{found['url']}: {found['shards'] - missing} of {found['shards']} shards of {found['recipe']}")
    return 1 if missing else 0


def _generate(asked: argparse.Namespace) -> int:
    options = {"threads": asked.threads, "retries": asked.retries, "scratch": asked.scratch}
    # Ray prints on standard output what its nodes say; that is for the result alone.
    with contextlib.redirect_stdout(sys.stderr):
        done = generate(asked.recipe, asked.n, asked.url, asked.engine, **_recipe(asked), **options)
    return _tell(asked, done, f"{done['url']}: {done['samples']} samples, {done['made_samples']} of them made now")


def _recipe(asked: argparse.Namespace) -> dict[str, Any]:
    return {"seed": asked.seed, "samples_per_shard": asked.samples_per_shard, "overrides": asked.set}


def _tell(asked: argparse.Namespace, result: Any, words: str) -> int:
    print(json.dumps(result, indent=2) if asked.json else words)
    return 0


def _part(text: str) -> tuple[int, int]:
    try:
        k, m = (int(number) for number in text.split("/"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not K/M, for instance 0/4 for the first of four parts") from None
    return k, m


def _whole(least: int) -> Callable[[str], int]:
    """Takes a whole number, `least` or more."""

    def read(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if number < least:
            raise argparse.ArgumentTypeError(f"{text}: give a whole number, {least} or more")
        return number

    return read


if __name__ == "__main__":
    raise SystemExit(main())
