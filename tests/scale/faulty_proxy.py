"""A proxy before a store, which lets requests fail or wait: `python faulty_proxy.py PORT TARGET_PORT SHARE SEED [plain]`.

SHARE of the requests meet one of five faults in turn: refused before the store sees them, an answer that says 500 although
the store did it, a connection that is cut before, one that is cut after (a lost answer), and an answer that comes late. At
the end it prints how many requests met which, as JSON. With `plain` it knows no conditional puts, as some stores.
"""

import http.client
import itertools
import json
import random
import signal
import sys
import threading
import time
from collections import Counter
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

FAULTS = ["refused", "denied although done", "cut before", "cut after", "late"]
LATE_S = 2.0
REFUSED = b'<?xml version="1.0"?><Error><Code>SlowDown</Code><Message>Please reduce your request rate.</Message></Error>'
BROKEN = b'<?xml version="1.0"?><Error><Code>InternalError</Code><Message>We encountered an error.</Message></Error>'
UNKNOWN = b'<?xml version="1.0"?><Error><Code>NotImplemented</Code><Message>A header is not implemented.</Message></Error>'


def serve(port: int, target: int, share: float, seed: int, plain: bool) -> None:
    chance, order, met, lock = random.Random(seed), itertools.cycle(FAULTS), Counter(), threading.Lock()

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def pass_on(self) -> None:
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            with lock:
                fault = next(order) if chance.random() < share else "none"
                met[fault] += 1
            if plain and "If-None-Match" in self.headers:
                with lock:
                    met["condition"] += 1
                return self.answer(501, [], UNKNOWN)
            if fault == "refused":
                return self.answer(503, [], REFUSED)
            if fault == "cut before":
                return self.cut()
            store = http.client.HTTPConnection("127.0.0.1", target, timeout=60)
            store.request(self.command, self.path, body, dict(self.headers.items()))
            given = store.getresponse()
            content = given.read()
            store.close()
            if fault == "late":
                time.sleep(LATE_S)
            if fault == "cut after":
                return self.cut()
            if fault == "denied although done":
                return self.answer(500, [], BROKEN)
            self.answer(given.status, given.getheaders(), content)

        def answer(self, status: int, headers: list[tuple[str, str]], content: bytes) -> None:
            self.send_response_only(status)
            length = str(len(content))
            for name, value in headers:
                if name.lower() == "content-length" and self.command == "HEAD":
                    length = value
                elif name.lower() not in ("content-length", "transfer-encoding", "connection"):
                    self.send_header(name, value)
            self.send_header("Content-Length", length)
            self.end_headers()
            if self.command != "HEAD":
                self.wfile.write(content)

        def cut(self) -> None:
            self.close_connection = True
            self.connection.close()

        def handle(self) -> None:
            try:
                super().handle()
            except (OSError, ValueError):
                pass  # cut, by us or by the client

        do_GET = do_PUT = do_POST = do_HEAD = do_DELETE = pass_on

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", port), Handler)
    server.daemon_threads = True
    signal.signal(signal.SIGTERM, lambda *_: threading.Thread(target=server.shutdown).start())
    print("ready", flush=True)
    server.serve_forever()
    print(json.dumps(met), flush=True)


if __name__ == "__main__":
    serve(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]), sys.argv[5:] == ["plain"])
