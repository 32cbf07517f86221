import { useSignal } from "@preact/signals";
import { t } from "../words/words";
import { late } from "./late";

const StatsPage = late(async () => (await import("../stats/StatsPage")).StatsPage);

/** Opens the details. */
export function Stats() {
  const isOpen = useSignal(false);
  return (
    <div class="details">
      <button
        type="button"
        class="plain-button"
        aria-expanded={isOpen.value}
        onClick={() => {
          isOpen.value = !isOpen.value;
        }}
      >
        {t("stats.button")}
      </button>
      {isOpen.value && (
        <section class="details-body" aria-label={t("stats.button")}>
          <StatsPage />
        </section>
      )}
    </div>
  );
}
