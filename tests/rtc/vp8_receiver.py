"""How libwebrtc decides from a VP8 picture's numbers which pictures it waits for.

Modelled on its class RtpVp8RefFinder: pictures that are handed off may be decoded.
"""

from __future__ import annotations

from dataclasses import dataclass, field

_REMEMBERED_PICTURES = 100
_REMEMBERED_BASES = 50


@dataclass(frozen=True)
class Arrived:
    """One whole picture, with the numbers of its descriptor, unwrapped."""

    picture_id: int
    tl0_picidx: int
    tid: int
    sync: bool
    keyframe: bool


@dataclass
class Receiver:
    """Receives pictures in the order of their arrival."""

    newest: int | None = None
    missing: set[int] = field(default_factory=set)
    layers: dict[int, list[int | None]] = field(default_factory=dict)
    waiting: list[Arrived] = field(default_factory=list)

    def take(self, picture: Arrived) -> list[int]:
        """Return the PictureIDs that are handed off now, in this order."""
        verdict = self._judge(picture)
        if verdict == "wait":
            self.waiting.append(picture)
        if verdict != "hand off":
            return []
        found = [picture.picture_id]
        again = True
        while again:
            again = False
            for other in list(self.waiting):
                verdict = self._judge(other)
                if verdict != "wait":
                    self.waiting.remove(other)
                if verdict == "hand off":
                    found.append(other.picture_id)
                    again = True
        return found

    def _judge(self, picture: Arrived) -> str:
        self._note(picture)
        base, tid = picture.tl0_picidx, picture.tid
        if picture.keyframe:
            if tid:
                return "drop"
            self.layers[base] = [None] * 4
            return self._hand_off(picture)
        known = self.layers.get(base - 1 if tid == 0 else base)
        if known is None:
            return "wait"
        if tid == 0 or picture.sync:
            known = self.layers.setdefault(base, list(known))
            before = known[tid]
            stale = before is not None and before >= picture.picture_id
            return "drop" if stale else self._hand_off(picture)
        for before in known[: tid + 1]:
            verdict = self._wants(before, picture.picture_id)
            if verdict != "hand off":
                return verdict
        return self._hand_off(picture)

    def _wants(self, before: int | None, number: int) -> str:
        """Judge `number` by `before`, the newest picture of a layer that it may refer to."""
        if before is None:
            return "wait"
        if before >= number:
            return "drop"
        return "wait" if any(before < m < number for m in self.missing) else "hand off"

    def _note(self, picture: Arrived) -> None:
        number = picture.picture_id
        if self.newest is None:
            self.newest = number
        oldest = number - _REMEMBERED_PICTURES
        self.missing = {other for other in self.missing if other >= oldest}
        self.newest = max(self.newest, oldest)
        self.missing.update(range(self.newest + 1, number + 1))
        self.newest = max(self.newest, number)
        last = picture.tl0_picidx - _REMEMBERED_BASES
        self.layers = {base: known for base, known in self.layers.items() if base >= last}

    def _hand_off(self, picture: Arrived) -> str:
        base, number = picture.tl0_picidx, picture.picture_id
        while base in self.layers:
            before = self.layers[base][picture.tid]
            if before is not None and before > number:
                break
            self.layers[base][picture.tid] = number
            base += 1
        self.missing.discard(number)
        return "hand off"
