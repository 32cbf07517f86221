import { expect, it } from "vitest";
import { oldestDom } from "./dom.js";

/** @param {Record<string, string | false>} added */
const since = (added) => {
  const support = Object.fromEntries(
    Object.entries({ chrome: "1", firefox: "1", safari: "1", safari_ios: "1", ...added }).map(
      ([name, version]) => [name, { version_added: version }],
    ),
  );
  return { __compat: { support } };
};

const LIB = `interface Camera extends EventTarget, Zoom {
    readonly name: string;
    shoot(): void;
    shoot(count: number): void;
    "quoted": string;
}
declare var Camera: {
    new(): Camera;
    isThere(): boolean;
};
interface Zoom {
    zoom: number;
}
interface Lamp {
    glow(): void;
    blink(): void;
}
declare var Lamp: {
    new(): Lamp;
};
declare var level: number;
declare function idle(): void;
declare function once(): void;`;

it("lets what an old browser lacks be undefined, and nothing else", () => {
  const api = {
    Camera: {
      ...since({}),
      name: since({ firefox: "128", safari: "16.4", chrome: "≤110" }),
      shoot: since({ firefox: "129" }),
      isThere_static: since({ safari_ios: false }),
      zoom: since({ chrome: "111" }),
    },
    Lamp: {
      ...since({ safari: "17" }),
      glow: since({ safari: "17" }),
      blink: since({ safari: "17", chrome: "120" }),
    },
    Window: { level: since({ safari: "17" }), idle: since({ safari: false }) },
  };
  const made = oldestDom(LIB, /** @type {any} */ (api));
  const changed = made.split("\n").filter((line) => !LIB.includes(line));
  expect(changed).toEqual([
    "    shoot?(): void;",
    "    shoot?(count: number): void;",
    "    isThere?(): boolean;",
    "    zoom?: number;",
    "    blink?(): void;",
    "declare var Lamp: undefined | {",
    "declare var level: undefined | number;",
  ]);
  expect(made).not.toContain("idle");
  expect(made).toContain("declare function once(): void;");
});

it("counts what is behind a switch, prefixed or gone as lacking", () => {
  const [first, flag, prefix, gone] = ["1", "2", "3", "4"].map((version_added) => ({
    version_added,
  }));
  const camera = (/** @type {unknown} */ safari) => ({
    Camera: {
      ...since({}),
      shoot: { __compat: { support: { ...since({}).__compat.support, safari } } },
    },
  });
  const isOptional = (/** @type {unknown} */ safari) =>
    oldestDom(LIB, /** @type {any} */ (camera(safari))).includes("shoot?");
  expect(isOptional([first])).toBe(false);
  expect(isOptional([{ ...flag, flags: [{}] }])).toBe(true);
  expect(isOptional([{ ...prefix, prefix: "webkit" }])).toBe(true);
  expect(isOptional([{ ...gone, version_removed: "16" }])).toBe(true);
  expect(isOptional([{ ...gone, version_removed: "18" }])).toBe(false);
  expect(isOptional([{ ...gone, version_removed: "16" }, first])).toBe(false);
});
