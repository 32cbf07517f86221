import { describe, expect, it } from "vitest";
import { controlInForce, DRIVE_DEFAULTS, loadDrivePreferences } from "./drivePreferences";

describe("what lies on the screen", () => {
  it("is a stick to fingers and buttons to a mouse, unless one of them was chosen", () => {
    expect(controlInForce(DRIVE_DEFAULTS, "hold", true)).toBe("stick");
    expect(controlInForce(DRIVE_DEFAULTS, "hold", false)).toBe("buttons");
    const chosen = { ...DRIVE_DEFAULTS, control: "stick" } as const;
    expect(controlInForce(chosen, "hold", false)).toBe("stick");
  });

  it("is buttons where a press is a step or a click, since a stick is held", () => {
    const chosen = { ...DRIVE_DEFAULTS, control: "stick" } as const;
    for (const way of ["step", "click", "scan"] as const) {
      expect(controlInForce(chosen, way, true)).toBe("buttons");
    }
  });

  it("is what suits the device where something else was stored", () => {
    expect(loadDrivePreferences({ control: "wheel" }).control).toBeNull();
    expect(loadDrivePreferences({ control: "buttons" }).control).toBe("buttons");
  });
});
