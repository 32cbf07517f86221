import { About } from "./About";
import { LossPanel } from "./LossPanel";

/** The host's own rules, and the robot's. */
export function RulesPanel() {
  return (
    <>
      <About />
      <LossPanel />
    </>
  );
}
