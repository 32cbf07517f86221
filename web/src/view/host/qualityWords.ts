import type { ConsoleViewer } from "../../messages";
import { figure, t } from "../../words/words";
import { sizeWords } from "../figures";

/** A viewer's connection, for the host: `42 ms, 640 × 480`. */
export function qualityWords(line: ConsoleViewer): string {
  const words = [
    ...(line.round_trip_ms === null
      ? []
      : [t("host.round_trip", { ms: figure(Math.round(line.round_trip_ms)) })]),
    ...(line.picture_ms === null
      ? []
      : [t("host.picture_age", { ms: figure(Math.round(line.picture_ms)) })]),
    line.rendition === null ? t("host.no_picture") : sizeWords(line.rendition),
  ];
  return words.join(", ");
}
