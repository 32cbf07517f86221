import { signal } from "@preact/signals";
import type { FunctionComponent } from "preact";
import { useEffect } from "preact/hooks";
import { t } from "../words/words";

type Part<Props> =
  | { is: "no" | "loading" | "failed" }
  | { is: "there"; Show: FunctionComponent<Props> };

/** Makes a component of a part that few pages need, loaded once where one is shown. */
export function late<Props extends object>(importPart: () => Promise<FunctionComponent<Props>>) {
  const part = signal<Part<Props>>({ is: "no" });

  /** Loads it, again after a failure. */
  const load = async (): Promise<void> => {
    if (part.peek().is === "loading" || part.peek().is === "there") return;
    part.value = { is: "loading" };
    try {
      part.value = { is: "there", Show: await importPart() };
    } catch {
      part.value = { is: "failed" };
    }
  };

  function Late(props: Props) {
    useEffect(() => void load(), []);
    const now = part.value;
    if (now.is === "there") return <now.Show {...props} />;
    return now.is === "failed" ? (
      <p role="status" class="quiet">
        {t("panels.not_loaded")}
      </p>
    ) : null;
  }
  return Object.assign(Late, { load });
}
