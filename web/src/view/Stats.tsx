import { useSignal } from "@preact/signals";
import type { ComponentType } from "preact";
import { isNeededForDriving } from "../link/thin";
import { t } from "../words/words";
import { useState } from "./context";

type Loaded = { is: "no" | "loading" | "failed" } | { is: "there"; Page: ComponentType };

/** What brings the details; another one in tests. */
type Load = () => Promise<{ StatsPage: ComponentType }>;

const LOAD: Load = () => import("../stats/StatsPage");

/** Opens the details, which are loaded at the first time: never while a thin link is driven over. */
export function Stats({ load = LOAD }: { load?: Load }) {
  const { served, drivingTurn } = useState();
  const isOpen = useSignal(false);
  const loaded = useSignal<Loaded>({ is: "no" });
  const isLoaded = loaded.value.is === "there";
  const isTooThin = !isLoaded && isNeededForDriving(served.value, drivingTurn.value);

  const get = () => {
    if (isLoaded || loaded.peek().is === "loading" || isTooThin) return;
    loaded.value = { is: "loading" };
    load().then(
      ({ StatsPage }) => {
        loaded.value = { is: "there", Page: StatsPage };
      },
      () => {
        loaded.value = { is: "failed" };
      },
    );
  };
  const toggle = () => {
    isOpen.value = !isOpen.value;
    if (isOpen.value) get();
  };

  return (
    <div class="details">
      <button
        type="button"
        class="plain-button"
        aria-expanded={isOpen.value}
        disabled={isTooThin && !isOpen.value}
        aria-describedby={isTooThin ? "details-why" : undefined}
        onClick={toggle}
      >
        {t("stats.button")}
      </button>
      {isTooThin && (
        <p id="details-why" class="quiet">
          {t("stats.too_thin")}
        </p>
      )}
      {isOpen.value && (
        <section class="details-body" aria-label={t("stats.button")}>
          <Body loaded={loaded.value} isTooThin={isTooThin} again={get} />
        </section>
      )}
    </div>
  );
}

function Body({
  loaded,
  isTooThin,
  again,
}: {
  loaded: Loaded;
  isTooThin: boolean;
  again: () => void;
}) {
  switch (loaded.is) {
    case "there":
      return <loaded.Page />;
    case "failed":
      return (
        <div role="alert">
          <p>{t("stats.failed")}</p>
          <button type="button" class="plain-button" disabled={isTooThin} onClick={again}>
            {t("stats.again")}
          </button>
        </div>
      );
    default:
      return <p role="status">{t("stats.loading")}</p>;
  }
}
