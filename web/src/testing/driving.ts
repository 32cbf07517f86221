/** A drive controller for tests, without a connection. */
import { DriveController, type DriveControllerOptions } from "../drive/driveController";
import type { State } from "../state";

export function controllerOf(
  state: State,
  more: Partial<DriveControllerOptions> = {},
): DriveController {
  return new DriveController({
    state,
    serverMs: () => 5000,
    beat: () => "x7-_2A",
    seenServerMs: () => null,
    uplink: () => ({ linkBps: 5_000_000, waitingBytes: 0, queuedMs: 0 }),
    operate: () => {},
    refused: () => {},
    send: () => {},
    ...more,
  });
}
