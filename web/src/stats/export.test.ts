import { expect, it } from "vitest";
import { sample } from "../testing/samples";
import { exported, fileName, SCHEMA_VERSION } from "./export";
import { FIELDS, History } from "./history";

const ABOUT = {
  nowMs: 10_000,
  wallMs: 1_700_000_000_000.4,
  version: "1.2.3",
  userAgent: "Browser/7",
  role: "observer",
  why: { code: "stats.why.nothing", values: {} },
} as const;

it("writes the history with units, ages and its schema's version", () => {
  const history = new History();
  history.add(sample(8000, { pictureMs: 41.26 }));
  history.add(sample(9000, { linkBps: 180_000 }));
  history.mark({ atMs: 8500, kind: "stop", text: "Stop is pressed" });
  const { samples, ...rest } = exported(history, ABOUT) as { samples: Record<string, unknown> };
  expect(rest).toEqual({
    schema: "wax-stats",
    schema_version: SCHEMA_VERSION,
    made_wall_ms: 1_700_000_000_000,
    server_version: "1.2.3",
    browser: { user_agent: "Browser/7" },
    role: "observer",
    why: { code: "stats.why.nothing", values: {} },
    marks: [{ age_ms: 1500, kind: "stop", text: "Stop is pressed" }],
  });
  expect(samples.age_ms).toEqual([2000, 1000]);
  expect(samples.picture_ms).toEqual([41.3, null]);
  expect(samples.link_bps).toEqual([null, 180_000]);
  expect(Object.keys(samples)).toHaveLength(FIELDS.length + 1);
});

it("can be read back unchanged", () => {
  const content = exported(new History(), { ...ABOUT, version: null, role: null });
  expect(JSON.parse(JSON.stringify(content))).toEqual(content);
});

it("is a file that sorts by its time", () => {
  const at = new Date(2026, 4, 3, 9, 5, 7).getTime();
  expect(fileName(at)).toBe("wax-stats-2026-05-03-09-05-07.json");
});
