"""The program `gen` as a child process: its arguments, its results as JSON, its events, and its faults in its own words."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import IO, Any

from sheetlight._sheetlight import version

VARIABLE = "SHEETLIGHT_GEN"
"""Environment variable that names another `gen` than the one of this package: the path of an executable file."""

PATIENCE_S = 10.0
"""How long a program that was asked to stop may take [s] before it is killed; it ends by itself in a small part of that."""


class GenError(RuntimeError):
    """`gen` ended with faults; the message is what it said.

    Attributes:
        status: exit status; 1 faults or a refusal, 2 unusable arguments, 130 stopped, below zero the signal that ended it
        words: what it said on standard error; of events, the text of faults alone
        output: what it wrote on standard output
        arguments: what it was called with
    """

    def __init__(self, status: int, words: str, output: str, arguments: list[str]):
        super().__init__(status, words, output, arguments)
        self.status = status
        self.words = words
        self.output = output
        self.arguments = arguments

    def __str__(self) -> str:
        said = self.words.strip().removeprefix("gen: ")
        if said:
            return said
        how = f"was ended by signal {-self.status}" if self.status < 0 else f"ended with status {self.status}"
        return f"gen {' '.join(self.arguments)} {how} and said nothing"


class Stop(threading.Event):
    """Stops the programs that threads run with it, those that start later too; an exception reaches the main thread alone."""

    def __init__(self) -> None:
        super().__init__()
        self._children: set[subprocess.Popen[bytes]] = set()
        self._lock = threading.Lock()

    def set(self) -> None:
        """Interrupts the programs and waits for them; one that does not end in PATIENCE_S is killed."""
        with self._lock:
            super().set()
            children = list(self._children)
        for child in children:
            _interrupt(child)
        for child in children:
            _end(child)

    @contextlib.contextmanager
    def held(self, child: subprocess.Popen[bytes]) -> Iterator[None]:
        """Stops this program too while the block runs."""
        with self._lock:
            self._children.add(child)
            if self.is_set():
                _interrupt(child)
        try:
            yield
        finally:
            with self._lock:
                self._children.discard(child)


def command() -> list[str]:
    """What starts `gen`: a list to put before its arguments.

    That is the file that the environment variable SHEETLIGHT_GEN names, or else the program in this package.
    """
    named = os.environ.get(VARIABLE)
    if named:
        return [named]
    if not sys.executable:
        raise RuntimeError(f"this Python does not say where its interpreter is; let {VARIABLE} name the program gen")
    # -P: a folder `sheetlight` where the user works must not be taken for this package.
    return [sys.executable, "-P", "-m", "sheetlight"]


def run(
    arguments: Iterable[str | os.PathLike[str]],
    *,
    on_event: Callable[[dict[str, Any]], None] | None = None,
    accept: Iterable[int] = (0,),
    stop: Stop | None = None,
    text: str | None = None,
) -> str:
    """Runs `gen` with these arguments and returns what it writes on standard output.

    Args:
        arguments: those after the program's name
        on_event: is called with each event of a run with `--events`, a dict with the key "event", by a
            thread of its own; what it raises stops the program and is raised here
        accept: exit statuses that are no faults
        stop: what another thread may stop it by
        text: what it reads on standard input

    Raises:
        GenError: it ended with another status.
        FileNotFoundError: SHEETLIGHT_GEN names no file.
    """
    words_of_call = [os.fspath(argument) for argument in arguments]
    program = command()
    written: list[bytes] = []
    words: list[str] = []
    raised: list[BaseException] = []
    readers: list[threading.Thread] = []

    def gather(stream: IO[bytes]) -> None:
        written.append(stream.read())

    def listen(stream: IO[bytes]) -> None:
        for line in stream:
            text = line.decode(errors="replace")
            event = _event(text)
            if event is None:
                words.append(text)
                continue
            if event["event"] in ("fault", "stopped"):
                words.append(f"{event.get('text', '')}\n")
            if on_event is not None and not raised:
                try:
                    on_event(event)
                except BaseException as fault:  # raised again by the caller's thread
                    raised.append(fault)
                    _interrupt(child)

    with contextlib.ExitStack() as files:
        said = None
        if text is not None:
            said = files.enter_context(tempfile.TemporaryFile())
            said.write(text.encode())
            said.seek(0)
        child = _start([*program, *words_of_call], said)
    try:
        for read, stream in ((gather, child.stdout), (listen, child.stderr)):
            reader = threading.Thread(target=read, args=(stream,), daemon=True)
            reader.start()
            readers.append(reader)
        with stop.held(child) if stop is not None else contextlib.nullcontext():
            status = child.wait()
    except BaseException:
        # Ctrl-C, or an exception that was thrown into this thread: the program stops as it does at a terminal.
        _interrupt(child)
        _end(child)
        raise
    finally:
        for reader in readers:
            reader.join()
        for pipe in (child.stdout, child.stderr):
            if pipe is not None:
                pipe.close()
    if raised:
        raise raised[0]
    # Of a program that is no gen, anything may come.
    output = b"".join(written).decode(errors="replace")
    if status not in accept:
        raise GenError(status, "".join(words), output, words_of_call)
    return output


def run_json(arguments: Iterable[str | os.PathLike[str]], kind: type = dict, **options: Any) -> Any:
    """The same with `--json`: the document that it writes, of that kind; `options` are those of `run`.

    Raises:
        GenError: it ended with another status, or what it wrote is no such document.
    """
    words_of_call = [*(os.fspath(argument) for argument in arguments), "--json"]
    output = run(words_of_call, **options)
    try:
        document = json.loads(output)
    except ValueError:
        document = None
    if not isinstance(document, kind):
        raise no_gen(output, words_of_call)
    return document


def no_gen(output: str, arguments: list[str]) -> GenError:
    """The fault of a program that ends well without having done what it was asked for."""
    remedy = f"let {VARIABLE} name a gen of version {version}, or unset it" if os.environ.get(VARIABLE) else "install sheetlight again"
    return GenError(0, f"{' '.join(command())} is no gen: it did nothing of what gen {arguments[0]} does; {remedy}", output, arguments)


def set_arguments(overrides: dict[str, Any]) -> list[str]:
    """The options `--set KEY=VALUE` of changes to a recipe; keys are dotted paths, values what JSON can say."""
    options = []
    for key, value in overrides.items():
        options += ["--set", f"{key}={override_text(key, value)}"]
    return options


def override_text(key: str, value: Any) -> str:
    """A value of a recipe as YAML, of which JSON is a part.

    Raises:
        TypeError, ValueError: it is nothing that a recipe can hold.
    """
    remedy = "give a number, a text, a list or a dict of these"
    try:
        return json.dumps(value, allow_nan=False, ensure_ascii=False, default=_plain)
    except TypeError:
        raise TypeError(f"{key}: a {type(value).__name__} is nothing that a recipe can hold; {remedy}") from None
    except ValueError:
        raise ValueError(f"{key}: {value!r} is nothing that a recipe can hold; {remedy}") from None


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as those of Python, paths as text."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError


def _start(command: list[str], said: IO[bytes] | None) -> subprocess.Popen[bytes]:
    try:
        return subprocess.Popen(command, stdin=subprocess.DEVNULL if said is None else said, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    except OSError as fault:
        if not os.environ.get(VARIABLE):
            raise
        words = f"{VARIABLE} names no program that can be started ({fault.strerror})"
        raise type(fault)(fault.errno, words, command[0]) from None


def _event(line: str) -> dict[str, Any] | None:
    if not line.startswith("{"):
        return None
    try:
        event = json.loads(line)
    except ValueError:
        return None
    return event if isinstance(event, dict) and "event" in event else None


def _interrupt(child: subprocess.Popen[bytes]) -> None:
    if child.poll() is None:
        child.send_signal(signal.SIGINT if os.name == "posix" else signal.SIGTERM)


def _end(child: subprocess.Popen[bytes]) -> None:
    """Waits for a program that was interrupted, and kills it where it takes too long."""
    try:
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(PATIENCE_S)
    finally:
        child.kill()
        child.wait()
