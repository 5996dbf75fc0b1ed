"""A place for the files of a dataset: a folder, or a bucket through fsspec.

A file appears under its name whole or not at all, in a bucket because stores work so, in a folder by a temporary name. Nothing
is locked: whoever writes a file of a dataset writes the same bytes.
"""

import errno
import itertools
import json
import logging
import os
import random
import re
import shutil
import threading
import time
import uuid
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Protocol, TypeVar
from urllib.parse import unquote, urlsplit

from .errors import Interruption, Refusal

Result = TypeVar("Result")

LOG = logging.getLogger("sheetlight.scale")

ATTEMPTS = 6
"""How often a request is tried."""

FIRST_PAUSE_S = 0.25
"""Pause before the second attempt [s]; each further one is twice as long, up to MOST_PAUSE_S, times 0.5 to 1 by chance."""

MOST_PAUSE_S = 8.0
"""Longest pause between attempts [s]."""

SILENCE_S = 2.0
"""How long attempts may fail before that is logged [s]; Python writes it to standard error unless logging is set up otherwise."""

REQUESTS = 8
"""Requests at the same time. An upload holds up to 100 MB of its file in memory."""

TEMPORARY = re.compile(r"^\.tmp-.+\.[0-9a-f]{32}$")
"""Names that files of a folder have while they are written."""

ONE_SLASH = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):/")
"""How URLs begin that lack a slash; a drive letter of Windows is no protocol."""

EXTRAS = {"s3": "s3", "s3a": "s3", "gs": "gs", "gcs": "gs", "az": "az", "abfs": "az", "abfss": "az", "hf": "hf"}
"""Protocols of object stores, and the extra of this package that brings what they need."""

NO_CREDENTIALS = {
    "NoCredentialsError", "PartialCredentialsError", "CredentialRetrievalError", "TokenRetrievalError", "SSOTokenLoadError",
    "UnauthorizedSSOTokenError", "ProfileNotFound", "DefaultCredentialsError", "RefreshError", "ClientAuthenticationError",
    "LocalTokenNotFoundError",
}  # fmt: skip
"""Exceptions of the libraries of stores that tell of credentials and are no PermissionError."""


class _Place(Protocol):
    """What a store can do, one attempt each; paths are relative to the dataset. Missing files are FileNotFoundError."""

    permissions: str
    """What to do where it is not permitted."""
    missing: str
    """What to do where nothing can be written because there is no such place."""

    def read(self, path: str) -> bytes: ...
    def write(self, path: str, content: bytes) -> None: ...
    def create(self, path: str, content: bytes) -> None:
        """FileExistsError where it is there already."""

    def upload(self, path: str, source: Path) -> None: ...
    def has(self, path: str) -> bool: ...
    def sizes(self, folder: str) -> dict[str, int]: ...
    def remove(self, path: str) -> None: ...


class Store:
    """The files of one dataset. Requests that fail are tried again; what remains is a Refusal or an Interruption.

    Attributes:
        url: where it is, as tasks on other machines find it; holds no credentials
    """

    def __init__(self, url: str | os.PathLike[str], stop: threading.Event | None = None):
        """
        Args:
            url: a folder (path or `file://`), `s3://`, `gs://`, `az://` or `hf://buckets/`; credentials come from the
                environment, as the store's own tools find them
            stop: once it is set, no further request is begun, which is an Interruption

        Raises:
            Refusal: it is none of these, holds credentials, or what the store needs is not installed.
        """
        self.url, self._place = _place(os.fspath(url))
        self._stop = stop or threading.Event()

    def read(self, path: str) -> bytes | None:
        """The bytes of a file; None where there is none."""
        try:
            return self._again("read", path, lambda: self._place.read(path), passing=(FileNotFoundError,))
        except FileNotFoundError as fault:
            if "NoSuchBucket" in _codes(fault):
                raise self._refusal("read", path, fault) from None
            return None

    def read_all(self, paths: Iterable[str]) -> dict[str, bytes]:
        """The same of many files, those that are there."""
        paths = list(paths)
        with ThreadPoolExecutor(2 * REQUESTS) as pool:
            return {path: content for path, content in zip(paths, pool.map(self.read, paths)) if content is not None}

    def write(self, path: str, content: bytes) -> None:
        """Writes a file, over one that is there."""
        self._again("write", path, lambda: self._place.write(path, content))

    def create(self, path: str, content: bytes) -> bool:
        """Writes a file where there is none; False where there is one."""
        try:
            self._again("write", path, lambda: self._place.create(path, content), passing=(FileExistsError,))
        except FileExistsError:
            return False
        return True

    def upload(self, folder: Path, paths: Iterable[str]) -> None:
        """Writes files that lie under the same paths in a folder of this machine."""

        def one(path: str) -> None:
            self._again("write", path, lambda: self._place.upload(path, folder / path))

        with ThreadPoolExecutor(REQUESTS) as pool:
            list(pool.map(one, paths))

    def has(self, path: str) -> bool:
        """Whether the file is there."""
        return self._again("read", path, lambda: self._place.has(path))

    def sizes(self, folder: str = "") -> dict[str, int]:
        """Sizes of all files below a folder of the dataset [bytes], by path: one listing."""
        return self._again("list", folder, lambda: self._place.sizes(folder))

    def remove(self, path: str) -> None:
        """Removes a file, which may be gone already."""
        self._again("remove", path, lambda: self._place.remove(path))

    def refuse_inside_dataset(self) -> None:
        """Refuses a folder in the folder of a dataset, where nothing else may lie; of buckets nothing is asked.

        Raises:
            Refusal: it lies in one.
        """
        if isinstance(self._place, _Folder):
            for folder in self._place.root.resolve().parents:
                if _holds_dataset(folder):
                    raise Refusal(f"{self.url}: it lies in the dataset {folder}, where nothing else may lie; choose a folder elsewhere")

    def at(self, path: str) -> str:
        """The file in words."""
        return f"{self.url}/{path}" if path else self.url

    def _again(
        self, what: str, path: str, attempt: Callable[[], Result], passing: tuple[type[Exception], ...] = ()
    ) -> Result:
        """Tries until it works or trying does not help; `passing` exceptions are results."""
        begun, told = time.monotonic(), False
        for number in range(ATTEMPTS):
            if self._stop.is_set():
                raise Interruption(f"{self.at(path)}: stopped, and did not {what} it; run the same again")
            try:
                return attempt()
            except passing:
                raise
            except Exception as fault:
                if _is_final(fault):
                    raise self._refusal(what, path, fault) from None
                last = fault
            if number + 1 < ATTEMPTS:
                if not told and time.monotonic() - begun > SILENCE_S:
                    told = True
                    LOG.warning("%s: cannot %s it yet: %s; trying again", self.at(path), what, _words(last))
                self._stop.wait(min(FIRST_PAUSE_S * 2**number, MOST_PAUSE_S) * random.uniform(0.5, 1))
        raise Interruption(
            f"{self.at(path)}: cannot {what} it after {ATTEMPTS} attempts: {_words(last)}; "
            "check the store and the network, then run the same again: what is finished is kept"
        ) from None

    def _refusal(self, what: str, path: str, fault: Exception) -> Refusal:
        remedy = "correct the URL, or put right what it says"
        if isinstance(fault, FileNotFoundError):
            remedy = self._place.missing
        elif _is_forbidden(fault):
            remedy = self._place.permissions
        elif isinstance(fault, OSError) and fault.errno in FULL:
            remedy = "make room there, then run the same again: what is finished is kept"
        elif isinstance(fault, OSError) and fault.errno == errno.EROFS:
            remedy = "it can only be read: choose another place"
        return Refusal(f"{self.at(path)}: cannot {what} it: {_words(fault)}; {remedy}")


NO_LINKS = {errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK, errno.EINVAL}
"""Error numbers of file systems without hard links: FAT, exFAT, some of FUSE and CIFS."""

NO_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EBADF}
"""Error numbers of file systems on which a folder cannot be synchronised."""

FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)}
"""Error numbers of a disk, or one's share of it, that takes no more."""


def _holds_dataset(folder: Path) -> bool:
    try:
        return json.loads((folder / "dataset.json").read_bytes())["format"] == "sheetlight-dataset"
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _is_final(fault: Exception) -> bool:
    """Whether another attempt would end alike."""
    if isinstance(fault, OSError) and fault.errno in FULL | {errno.EROFS, errno.ENAMETOOLONG, errno.ENOTDIR}:
        return True
    finals = (FileNotFoundError, FileExistsError, ImportError, TypeError, ValueError)
    # botocore's name for arguments that it does not send, such as an impossible name of a bucket.
    return isinstance(fault, finals) or type(fault).__name__ == "ParamValidationError" or _is_forbidden(fault)


def _is_forbidden(fault: Exception) -> bool:
    """Whether credentials are at fault, or missing."""
    # gcsfs has no better name for it than an OSError that says so.
    said_so = isinstance(fault, OSError) and str(fault).startswith("Forbidden")
    return isinstance(fault, PermissionError) or type(fault).__name__ in NO_CREDENTIALS or said_so


def _words(fault: BaseException) -> str:
    """What an exception says, on one line."""
    if isinstance(fault, OSError) and fault.strerror:
        return fault.strerror
    said = " ".join(str(fault).split())
    return said or type(fault).__name__


def _codes(fault: BaseException | None) -> set[str]:
    """The store's own names of a fault, of its causes too."""
    codes = set()
    while fault is not None:
        response = getattr(fault, "response", None)
        if isinstance(response, dict):
            codes.add(str(response.get("Error", {}).get("Code")))
        fault = fault.__cause__
    return codes


def _place(url: str) -> tuple[str, _Place]:
    """The URL without what depends on the working folder, and what reads and writes there."""
    protocol, separator, rest = url.partition("://")
    if not separator or protocol == "file":
        named = unquote(urlsplit(url).path) if separator else url
        if not named:
            raise Refusal(f"{url!r} names no folder; give a path, . for the working directory, or a URL such as s3://bucket/planks")
        if separator and not rest.startswith(("/", "localhost/")):
            raise Refusal(f"{url}: names another machine; give file:///PATH, three slashes, or the path alone")
        if not separator and (lacking := ONE_SLASH.match(url)):
            meant = f"{lacking[1]}://{url[lacking.end():]}"
            raise Refusal(
                f"{url}: a URL has two slashes, {meant}, of which pathlib leaves one; give it as a text, or ./{url} for a folder"
            )
        path = Path(named).expanduser().absolute()
        return str(path), _Folder(path)
    host = rest.partition("/")[0]
    if ":" in host.rpartition("@")[0] or "?" in rest:
        raise Refusal(
            f"{protocol}://...: the URL holds credentials or a query; give the plain URL of the place, and credentials in "
            "the environment, where the store's own tools look for them"
        )
    if protocol not in EXTRAS:
        known = ", ".join(f"{name}://" for name in EXTRAS)
        raise Refusal(f"{url}: cannot write to {protocol}://; give a folder, or one of {known}")
    if protocol == "hf" and not rest.startswith("buckets/"):
        raise Refusal(
            f"{url}: each file written to a repository of the hub is a commit of its own; write to a bucket, "
            "hf://buckets/OWNER/NAME/..., or to a folder and run `hf upload-large-folder`"
        )
    if not host:
        raise Refusal(f"{url}: names no bucket; give for instance {protocol}://bucket/planks")
    try:
        import fsspec

        files, root = fsspec.core.url_to_fs(url, use_listings_cache=False)
    except ImportError as fault:
        extra = EXTRAS[protocol]
        raise Refusal(f"{url}: {_words(fault)}; pip install 'sheetlight[{extra}]'") from None
    except Exception as fault:
        raise Refusal(f"{url}: cannot be opened: {_words(fault)}; check the URL and the environment") from None
    return url.rstrip("/"), _Bucket(files, root.rstrip("/"))


class _Folder:
    """A folder of this machine, or one that machines share."""

    permissions = "check owner and permissions of the folder"
    missing = "there is no such folder and it cannot be made: correct the path"

    def __init__(self, root: Path):
        self.root = root

    def read(self, path: str) -> bytes:
        return (self.root / path).read_bytes()

    def write(self, path: str, content: bytes) -> None:
        self._replace(path, lambda file: file.write(content))

    def create(self, path: str, content: bytes) -> None:
        # A link, and not a file that is opened to be created: whoever finds it finds it whole.
        self._replace(path, lambda file: file.write(content), _link)

    def upload(self, path: str, source: Path) -> None:
        with source.open("rb") as origin:
            self._replace(path, lambda file: shutil.copyfileobj(origin, file, 1 << 20))

    def has(self, path: str) -> bool:
        return (self.root / path).is_file()

    def sizes(self, folder: str) -> dict[str, int]:
        found = {}
        for place, _, names in os.walk(self.root / folder, onerror=_unless_missing):
            for name in names:
                file = Path(place, name)
                try:
                    found[file.relative_to(self.root).as_posix()] = file.stat().st_size
                except FileNotFoundError:
                    pass  # a temporary name that has just become the final one
        return found

    def remove(self, path: str) -> None:
        (self.root / path).unlink(missing_ok=True)

    def _replace(self, path: str, fill: Callable[[Any], Any], name: Callable[[Path, Path], Any] = os.replace) -> None:
        target = self.root / path
        above = [target.parent, *target.parent.parents]
        new = list(itertools.takewhile(lambda folder: not folder.exists(), above))
        target.parent.mkdir(parents=True, exist_ok=True)
        partial = target.with_name(f".tmp-{target.name}.{uuid.uuid4().hex}")
        try:
            with partial.open("xb") as file:
                fill(file)
                file.flush()
                os.fsync(file.fileno())
            try:
                name(partial, target)
            except FileNotFoundError:
                # Somebody who finished the dataset took it for what a killed upload left.
                raise OSError(errno.EBUSY, "somebody removed its temporary file") from None
        finally:
            partial.unlink(missing_ok=True)
        # The name as well as the bytes outlasts a loss of power, before anything that relies on it is written.
        for folder in (target.parent, *(folder.parent for folder in new)):
            _sync(folder)


def _link(partial: Path, target: Path) -> None:
    """Gives a file its name unless there is one of that name.

    Raises:
        FileExistsError: there is one.
    """
    try:
        os.link(partial, target)
    except OSError as fault:
        if fault.errno not in NO_LINKS:
            raise
        # As in a store without conditional puts: two that begin in the same second are not told apart.
        if target.exists():
            raise FileExistsError(target) from None
        os.replace(partial, target)


def _sync(folder: Path) -> None:
    """Lets the names in a folder outlast a loss of power, where the system can."""
    if os.name != "posix":
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    except OSError as fault:
        if fault.errno not in NO_SYNC:
            raise
    finally:
        os.close(opened)


def _unless_missing(fault: OSError) -> None:
    if not isinstance(fault, FileNotFoundError):
        raise fault


class _Bucket:
    """A place in an object store, through fsspec."""

    permissions = "check the credentials in the environment, and that they may list, read and write there"
    missing = "there is no such bucket: create it first, or correct the URL and the endpoint"

    def __init__(self, files: Any, root: str):
        self.files = files
        self.root = root

    def read(self, path: str) -> bytes:
        return self.files.cat_file(self._key(path))

    def write(self, path: str, content: bytes) -> None:
        self.files.pipe_file(self._key(path), content)

    def create(self, path: str, content: bytes) -> None:
        try:
            self.files.pipe_file(self._key(path), content, mode="create")
        except Exception as fault:
            if "PreconditionFailed" in _codes(fault):  # of S3; those of other stores raise FileExistsError
                raise FileExistsError(path) from None
            if "NotImplemented" not in _codes(fault):
                raise
            # A store without conditional puts: two that begin in the same second are not told apart.
            if self.has(path):
                raise FileExistsError(path) from None
            self.write(path, content)

    def upload(self, path: str, source: Path) -> None:
        self.files.put_file(os.fspath(source), self._key(path))

    def has(self, path: str) -> bool:
        # `exists` of fsspec takes any fault for "no".
        try:
            self.files.info(self._key(path))
        except FileNotFoundError:
            return False
        return True

    def sizes(self, folder: str) -> dict[str, int]:
        try:
            found = self.files.find(self._key(folder) if folder else self.root, detail=True)
        except FileNotFoundError as fault:
            if "NoSuchBucket" in _codes(fault):
                raise
            return {}
        return {name.removeprefix(f"{self.root}/"): entry["size"] for name, entry in found.items()}

    def remove(self, path: str) -> None:
        try:
            self.files.rm_file(self._key(path))
        except FileNotFoundError:
            pass

    def _key(self, path: str) -> str:
        return f"{self.root}/{path}"
