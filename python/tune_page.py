"""`gen tune` and Chromium, for what tests, measures and pictures the page.

    with Tune(gen, "mine.yaml", folder) as tune, Chromium() as chromium:
        tab = chromium.tab(tune.address, 1600, 1000)
        tab.wait("document.getElementById('state').textContent.includes('whole scan is there')")

Chromium is driven over its own pipe (`--remote-debugging-pipe`, messages that a zero byte ends): no port is open. Needs
nothing but Python and, for the browser, Chromium (`apt-get install chromium`).
"""

import base64
import contextlib
import json
import os
import select
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import urllib.request

LIMIT_S = 120


class Tune:
    """The server, and questions to it past any browser."""

    def __init__(self, gen, recipe, folder=".", arguments=()):
        self.process = subprocess.Popen(
            [os.path.abspath(gen), "tune", str(recipe), *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self.address = self.process.stdout.readline().strip()
        if not self.address.startswith("http://127.0.0.1:"):
            raise RuntimeError(f"gen tune ended: {self.process.stderr.read()}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def ask(self, name, **question):
        """The answer: a document, a head with the bytes behind it, or the bytes of a picture."""
        body = json.dumps(question.get("plain", question)).encode()
        request = urllib.request.Request(f"{self.address}api/{name}", body, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=LIMIT_S) as answer:
            content, kind = answer.read(), answer.headers["Content-Type"]
        if kind == "application/json":
            return json.loads(content)
        if kind == "image/png":
            return content
        (length,) = struct.unpack_from("<I", content)
        return json.loads(content[4 : 4 + length]), content[4 + length :]

    def memory_mb(self):
        """What the process holds of memory (Linux)."""
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as status:
            return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmRSS"))

    def processor_s(self):
        """Processor time of all of its threads so far (Linux)."""
        with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as stat:
            fields = stat.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def interrupt(self):
        """Ctrl-C: the exit status, and what is said."""
        self.process.send_signal(signal.SIGINT)
        _, said = self.process.communicate(timeout=10)
        return self.process.returncode, said


class Chromium:
    """A browser without a window."""

    def __init__(self):
        names = ("chromium", "chromium-browser", "google-chrome")
        program = next((found for name in names if (found := shutil.which(name))), None)
        if program is None:
            raise RuntimeError("Chromium is missing: apt-get install chromium")
        self.profile = tempfile.TemporaryDirectory()
        theirs_in, self.out = os.pipe()
        self.inward, theirs_out = os.pipe()
        command = [
            program, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync", "--disable-quic",
            "--disable-background-networking", "--disable-component-update", "--disable-dev-shm-usage", "--hide-scrollbars",
            "--remote-debugging-pipe", f"--user-data-dir={self.profile.name}", "about:blank",
        ]
        # The pipe is that of descriptors 3 and 4.
        shell = f'exec "$@" 3<&{theirs_in} 4>&{theirs_out}'
        self.process = subprocess.Popen(
            ["bash", "-c", shell, "bash", *command], pass_fds=(theirs_in, theirs_out), stderr=subprocess.DEVNULL
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self.buffer, self.number, self.answers, self.events = b"", 0, {}, []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        with contextlib.suppress(Exception):
            self.call("Browser.close")
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.out)
        os.close(self.inward)
        with contextlib.suppress(OSError):
            self.profile.cleanup()

    def call(self, method, session=None, **parameters):
        self.number += 1
        number = self.number
        message = {"id": number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.out, data) :]
        end = time.monotonic() + LIMIT_S
        while number not in self.answers:
            self.read(end - time.monotonic())
        answer = self.answers.pop(number)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def read(self, seconds):
        if seconds <= 0 or not select.select([self.inward], [], [], seconds)[0]:
            raise TimeoutError("Chromium does not answer")
        part = os.read(self.inward, 1 << 20)
        if not part:
            raise RuntimeError("Chromium has ended")
        self.buffer += part
        *messages, self.buffer = self.buffer.split(b"\0")
        for message in map(json.loads, messages):
            if "id" in message:
                self.answers[message["id"]] = message
            else:
                self.events.append(message)

    def tab(self, address, width, height, dark=False):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        return Tab(self, session, address, width, height, dark)


class Tab:
    """A page."""

    def __init__(self, chromium, session, address, width, height, dark):
        self.chromium, self.session = chromium, session
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 500)
        scheme = "dark" if dark else "light"
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.call("Page.navigate", url=address)
        self.wait("location.href !== 'about:blank' && document.readyState === 'complete'")

    def call(self, method, **parameters):
        return self.chromium.call(method, self.session, **parameters)

    def run(self, script):
        """What an expression of the page is worth; promises are waited for."""
        answer = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{script[:200]}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait(self, condition, seconds=LIMIT_S):
        end = time.monotonic() + seconds
        while not self.run(condition):
            if time.monotonic() > end:
                raise TimeoutError(f"never: {condition}; the page says {self.run('document.body.innerText')[:400]}")
            time.sleep(0.02)

    def faults(self):
        """Errors on the console, exceptions, and requests to anywhere else."""
        found = []
        for event in self.chromium.events:
            if event.get("sessionId") != self.session:
                continue
            method, told = event["method"], event["params"]
            if method == "Runtime.exceptionThrown":
                found.append(told["exceptionDetails"].get("exception", {}).get("description", str(told)))
            elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning", "assert"):
                found.append(str(told["args"]))
            elif method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
                found.append(f"{told['entry']['text']} {told['entry'].get('url', '')}")
            elif method == "Network.requestWillBeSent":
                url = told["request"]["url"]
                if not url.startswith(("http://127.0.0.1:", "data:", "blob:http://127.0.0.1:")):
                    found.append(f"request to {url}")
        return found

    def key(self, name):
        for kind in ("keyDown", "keyUp"):
            text = {"text": "\r"} if name == "Enter" and kind == "keyDown" else {}
            self.call("Input.dispatchKeyEvent", type=kind, key=name, code=name, **text)

    def screenshot(self):
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
