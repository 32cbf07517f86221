import { generate } from "lean-qr";
import { toSvgPath } from "lean-qr/extras/svg";
import { useMemo } from "preact/hooks";
import { t } from "../words/words";

/** The margin that a reader needs (ISO/IEC 18004), in modules. */
const QUIET = 4;

/** An address as a QR code: black on white in every theme, since readers need that. */
export function QrCode({ address }: { address: string }) {
  const code = useMemo(() => generate(address), [address]);
  const size = code.size + 2 * QUIET;
  return (
    <svg
      class="big-screen-qr"
      role="img"
      aria-label={t("big_screen.qr", { address })}
      viewBox={`${-QUIET} ${-QUIET} ${size} ${size}`}
    >
      <rect x={-QUIET} y={-QUIET} width={size} height={size} fill="#ffffff" />
      <path d={toSvgPath(code)} fill="#000000" shape-rendering="crispEdges" />
    </svg>
  );
}
