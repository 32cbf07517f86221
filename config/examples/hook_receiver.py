"""A receiver of hooks: it prints what WAX has signed, and refuses everything else.

    [[hook]]
    url = "http://127.0.0.1:8090"
    secret_file = "/etc/wax/hook-secret"

Start it by `python3 hook_receiver.py 8090 /etc/wax/hook-secret`; `wax hook test` sends a sample.
"""

import base64
import hmac
import json
import sys
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

PORT, SECRET_FILE = int(sys.argv[1]), Path(sys.argv[2])
SECRET = base64.b64decode(SECRET_FILE.read_text(encoding="ascii").strip().removeprefix("whsec_"))


class Receiver(BaseHTTPRequestHandler):
    def do_POST(self) -> None:
        number, sent_s = self.headers["webhook-id"], self.headers["webhook-timestamp"]
        body = self.rfile.read(min(int(self.headers["Content-Length"]), 65_536))
        signed = hmac.digest(SECRET, f"{number}.{sent_s}.".encode() + body, "sha256")
        mine, given = b"v1," + base64.b64encode(signed), str(self.headers["webhook-signature"])
        is_signed = hmac.compare_digest(mine, given.encode())
        is_valid = is_signed and abs(time.time() - int(sent_s)) < 300  # else somebody replays it
        self.send_response(204 if is_valid else 401)
        self.end_headers()
        if is_valid:  # WAX repeats an event whose answer it has lost, with the same number
            event = json.loads(body)
            print(event["timestamp"], event["type"], event.get("name") or "", flush=True)


ThreadingHTTPServer(("127.0.0.1", PORT), Receiver).serve_forever()
