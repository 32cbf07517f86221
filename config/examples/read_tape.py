"""A reader of the tape: how far each turn went, and which commands the gate refused.

Start it by `python3 read_tape.py FILE.mcap`. The file has a JSON schema for each topic.
"""

import json
import math
import sys
from collections import Counter, defaultdict
from pathlib import Path

from mcap.reader import make_reader

driven_m: defaultdict[int, float] = defaultdict(float)
refused: Counter[str] = Counter()
turn, speed_mps, since_s = 0, 0.0, 0.0

with Path(sys.argv[1]).open("rb") as file:
    for _schema, _channel, message in make_reader(file).iter_messages(
        ["/wax/steered", "/wax/commanded"]
    ):
        event, now_s = json.loads(message.data), message.log_time / 1e9
        if event["type"] == "commanded":
            refused.update([event["refused"]] if event["refused"] else [])
            continue
        if speed_mps:
            driven_m[turn] += speed_mps * (now_s - since_s)  # a set-point lasts until the next
        turn, since_s = event["turn"], now_s
        speed_mps = math.hypot(event["linear_mps"], event.get("lateral_mps", 0.0))

for number, metres in driven_m.items():
    print(f"turn {number}: {metres:.2f} m")
for why, count in refused.most_common():
    print(f"refused as {why}: {count}")
