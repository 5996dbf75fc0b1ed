"""What every example asks first: is this a dataset that it can read? And where its files are.

    head = open_dataset("DIR")      dataset.json as dict; ends the program where the schema is newer
    has_exr(head)                   whether there are EXR files
    exr_path("DIR", head, row)      the EXR file of a row
    with needed(): import polars    ends the program with a remedy where a package is missing
"""

import contextlib
import json
import sys
from pathlib import Path

FORMAT = "sheetlight-dataset"
# Newer minor numbers only add; a newer major number may mean another thing by the same name.
MAJOR, OLDEST_MINOR = 1, 2


def refusal(document):
    """Why a document (dataset.json or a manifest) cannot be read here, or None."""
    if document.get("format") != FORMAT:
        return f"its format is {document.get('format')!r}, not {FORMAT!r}"
    major, minor = document.get("schema_version", [0, 0])
    if major > MAJOR:
        return f"it was written with schema {major}.{minor}, newer than {MAJOR}.x that this example reads; use newer examples"
    if (major, minor) < (MAJOR, OLDEST_MINOR):
        return f"it was written with schema {major}.{minor}, older than {MAJOR}.{OLDEST_MINOR} that this example reads; use older examples"
    return None


def open_dataset(root):
    """dataset.json of the folder; ends the program, with a reason and a remedy, where it cannot be read."""
    path = Path(root) / "dataset.json"
    try:
        head = json.loads(path.read_text())
    except (OSError, ValueError) as fault:
        raise SystemExit(f"{path}: {fault}; name the folder of a dataset") from None
    reason = refusal(head)
    if reason:
        raise SystemExit(f"{path}: {reason}")
    return head


def folder(usage):
    """The folder on the command line and its dataset.json."""
    if len(sys.argv) != 2:
        raise SystemExit(usage)
    root = Path(sys.argv[1]).resolve()
    return root, open_dataset(root)


def has_exr(head):
    """Whether a dataset has EXR files; before schema 1.9 truth maps needed another image beside them."""
    asked = head["images"]
    return bool(asked["exr"]) or asked["truth_maps"] and tuple(head["schema_version"]) >= (1, 9)


def exr_path(root, head, row):
    """The EXR file of a row: shards are named by their number; those after the first thousand lie in a folder for each thousand."""
    shard = row["index"] // head["samples_per_shard"]
    thousand = f"{shard // 1000:03}" if shard >= 1000 else ""
    return Path(root) / "exr" / thousand / f"{shard:05}" / f"{row['id']}.exr"


def images(head, *names):
    """Ends the program where the tables lack one of these images."""
    lacking = [name for name in names if name not in head["images"]["png"]]
    if lacking:
        remedy = "read the EXR files (load_openexr.py)" if set(lacking) <= set(head["images"]["exr"]) else "make it anew with output.png"
        raise SystemExit(f"the tables of this dataset hold no images {', '.join(lacking)}; {remedy}")


@contextlib.contextmanager
def needed():
    """Around imports: a missing package is told with its remedy."""
    try:
        yield
    except ModuleNotFoundError as missing:
        raise SystemExit(
            f"the package {missing.name} is missing: `make venv` installs it into .venv, "
            "or pip install -r python/requirements.txt"
        ) from None
