import { signal } from "@preact/signals";
import type { FunctionComponent } from "preact";
import { useEffect } from "preact/hooks";
import { loadLaterEnglish, t } from "../words/words";
import { useState } from "./context";

type Part<Props> =
  | { is: "no" | "loading" | "failed" }
  | { is: "there"; Show: FunctionComponent<Props> };

/**
 * Makes a component of a part that few pages need; it is loaded once, when first shown. While
 * driving needs all of a thin link, only parts that driving itself needs are loaded; their words
 * are in the first load. A part drawn over the picture shows nothing until it is loaded.
 */
export function late<Props extends object>(
  importPart: () => Promise<FunctionComponent<Props>>,
  { isForDriving = false, isOverPicture = false } = {},
) {
  const part = signal<Part<Props>>({ is: "no" });

  /** Loads the part, and retries after a failure. */
  const load = async (): Promise<void> => {
    if (part.peek().is === "loading" || part.peek().is === "there") return;
    part.value = { is: "loading" };
    try {
      const [Show] = await Promise.all([importPart(), isForDriving || loadLaterEnglish()]);
      part.value = { is: "there", Show };
    } catch {
      part.value = { is: "failed" };
    }
  };

  function Late(props: Props) {
    const { isLinkForDriving } = useState();
    const waits = !isForDriving && isLinkForDriving.value;
    useEffect(() => {
      if (!waits) void load();
    }, [waits]);
    const now = part.value;
    if (now.is === "there") return <now.Show {...props} />;
    if (isOverPicture) return null;
    if (now.is === "failed" && !waits) {
      return (
        <div role="alert">
          <p>{t("late.failed")}</p>
          <button type="button" class="plain-button" onClick={() => void load()}>
            {t("late.again")}
          </button>
        </div>
      );
    }
    return (
      <p role="status" class="quiet">
        {t(waits ? "late.waits" : "late.loading")}
      </p>
    );
  }
  return Object.assign(Late, { load });
}
