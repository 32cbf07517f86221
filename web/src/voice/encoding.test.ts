import { describe, expect, it } from "vitest";
import { ENCODINGS, EncodingChooser, type Uplink, wireBps } from "./encoding";

const WIDE: Uplink = { linkBps: 5_000_000, waitingBytes: 0, roundTripMs: 40, commandHz: 20 };

const [BEST, SHORT, THIN] = ENCODINGS;

function chosen(uplink: Partial<Uplink>): unknown {
  return new EncodingChooser().next({ ...WIDE, ...uplink }, false, 0);
}

it("delays a command by at most 40 ms at 33 kbit/s", () => {
  const bits = (THIN?.bitrateBps ?? 0) * 0.001 * (THIN?.packetMs ?? 0) + 58 * 8;
  expect(bits / 33.6).toBeLessThan(40);
});

it.each([
  [5_000_000, 20, BEST],
  [null, 20, SHORT],
  [300_000, 20, SHORT],
  [100_000, 20, THIN],
  [56_000, 0, THIN],
  [56_000, 20, null],
  [30_000, 0, null],
])("over a link of %s bit/s with %d commands a second", (linkBps, commandHz, encoding) => {
  expect(chosen({ linkBps, commandHz })).toEqual(encoding);
});

it("leaves room for all commands, whatever the link", () => {
  for (let linkBps = 1000; linkBps < 10_000_000; linkBps *= 1.1) {
    for (const commandHz of [0, 20, 50]) {
      const encoding = new EncodingChooser().next({ ...WIDE, linkBps, commandHz }, false, 0);
      const uplinkBps = Math.max(0.1 * linkBps, Math.min(0.6 * linkBps, 100_000));
      if (encoding) expect(wireBps(encoding) + commandHz * 1520).toBeLessThanOrEqual(uplinkBps);
    }
  }
});

describe("if commands wait", () => {
  function speaking(): EncodingChooser {
    const chooser = new EncodingChooser();
    for (let ms = 0; ms <= 5000; ms += 200) chooser.next(WIDE, false, ms);
    expect(chooser.next(WIDE, true, 5200)).toBe(BEST);
    return chooser;
  }

  it.each([{ waitingBytes: 400 }, { roundTripMs: 140 }])("it steps down at once: %o", (sign) => {
    const chooser = speaking();
    expect(chooser.next({ ...WIDE, ...sign }, true, 5400)).toBe(SHORT);
    expect(chooser.next({ ...WIDE, ...sign }, true, 5600)).toBe(SHORT);
    expect(chooser.next({ ...WIDE, ...sign }, true, 6500)).toBe(THIN);
    expect(chooser.next({ ...WIDE, ...sign }, true, 7600)).toBeNull();
    expect(chooser.next(WIDE, true, 8000)).toBeNull();
  });

  it("it is retried after a while", () => {
    const chooser = speaking();
    chooser.next({ ...WIDE, waitingBytes: 400 }, true, 5400);
    expect(chooser.next(WIDE, true, 20_000)).toBe(SHORT);
    expect(chooser.next(WIDE, true, 20_500)).toBe(BEST);
  });

  it("a long round trip without a voice does not count", () => {
    const chooser = new EncodingChooser();
    const far = { ...WIDE, roundTripMs: 300 };
    for (let ms = 0; ms <= 5000; ms += 200) chooser.next(far, false, ms);
    for (let ms = 5200; ms <= 9000; ms += 200) expect(chooser.next(far, true, ms)).toBe(BEST);
  });
});
