import { describe, expect, it } from "vitest";
import { controlInForce, DRIVE_DEFAULTS, loadDrivePreferences } from "./drivePreferences";

describe("the control on the screen", () => {
  it("is a stick for fingers and buttons for a mouse, unless one was chosen", () => {
    expect(controlInForce(DRIVE_DEFAULTS, "hold", true)).toBe("stick");
    expect(controlInForce(DRIVE_DEFAULTS, "hold", false)).toBe("buttons");
    const chosen = { ...DRIVE_DEFAULTS, control: "stick" } as const;
    expect(controlInForce(chosen, "hold", false)).toBe("stick");
  });

  it("is buttons if a press is a step or a click, since a stick must be held", () => {
    const chosen = { ...DRIVE_DEFAULTS, control: "stick" } as const;
    for (const way of ["step", "click", "scan"] as const) {
      expect(controlInForce(chosen, way, true)).toBe("buttons");
    }
  });

  it("suits the device if the stored choice is invalid", () => {
    expect(loadDrivePreferences({ control: "wheel" }).control).toBeNull();
    expect(loadDrivePreferences({ control: "buttons" }).control).toBe("buttons");
  });
});
