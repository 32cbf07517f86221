import { ROBOT_NUMBERS, type RobotStatus } from "../messages";
import { figure, t } from "../words/words";

type RobotNumber = (typeof ROBOT_NUMBERS)[number];
type Report = Pick<RobotStatus, RobotNumber["name"]>;

/** The codes of the numbers' names; numbers with the same code share a line. */
export const NAMES = [...new Set(ROBOT_NUMBERS.map(({ words }) => words))];

/** The numbers with this name that the robot reports, with their units. */
export function numbersNamed(code: RobotNumber["words"], robot: Report): string[] {
  return told(
    ROBOT_NUMBERS.filter(({ words }) => words === code),
    robot,
  );
}

/** The numbers that the page of `wax replay` shows. */
export function replayedNumbers(reported: Report): string[] {
  return told(
    ROBOT_NUMBERS.filter((one) => one.is_replayed),
    reported,
  );
}

function told(numbers: readonly RobotNumber[], report: Report): string[] {
  return numbers.flatMap(({ name, factor, decimals, unit }) => {
    const value = report[name];
    if (value === null) return [];
    return [t("figures.quantity", { figure: figure(value * factor, decimals), unit })];
  });
}
