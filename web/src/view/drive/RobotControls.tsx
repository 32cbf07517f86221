import { useState } from "../context";
import { late } from "../late";

export const ControlSet = late(async () => (await import("./ControlSet")).ControlSet, {
  isForDriving: true,
});

/**
 * The robot's controls besides wheels and axes, for those who may use them. The operator keeps
 * seeing theirs while the person aboard has the robot.
 */
export function RobotControls() {
  const { hello, drivingTurn, usableControls } = useState();
  const isDriving = drivingTurn.value !== null;
  const shown = (hello.value?.controls ?? []).filter(
    (one) => usableControls.value.includes(one) || (isDriving && one.roles.includes("operator")),
  );
  return shown.length === 0 ? null : <ControlSet shown={shown} />;
}
