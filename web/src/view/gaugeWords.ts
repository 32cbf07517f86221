import type { GaugeInfo } from "../messages";
import { figure, t } from "../words/words";

/** A gauge's value with its unit, in the reader's number format. */
export function gaugeWords(gauge: GaugeInfo, value: number | undefined): string {
  if (value === undefined) return t("controls.untold");
  return [figure(value, gauge.decimals), gauge.unit].filter(Boolean).join(" ");
}
