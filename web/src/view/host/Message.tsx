import { useSignal } from "@preact/signals";
import { t } from "../../words/words";
import { useActions, useState } from "../context";

const MAX_CHARS = 200;

/** A sentence that everybody sees until it is taken away. */
export function Message() {
  const { room } = useState();
  const { actAsHost } = useActions();
  const draft = useSignal("");
  const shown = room.value?.host_settings.message ?? "";
  const announce = (text: string) => {
    actAsHost({ type: "announce", text });
    draft.value = "";
  };
  return (
    <section class="host-section" aria-labelledby="message-title">
      <h3 id="message-title">{t("message.title")}</h3>
      <form
        class="host-row"
        onSubmit={(event) => {
          event.preventDefault();
          if (draft.value.trim()) announce(draft.value.trim());
        }}
      >
        <input
          type="text"
          dir="auto"
          maxLength={MAX_CHARS}
          aria-label={t("message.title")}
          placeholder={shown || t("message.example")}
          value={draft.value}
          onInput={(event) => {
            draft.value = event.currentTarget.value;
          }}
        />
        <button type="submit" class="main-button" disabled={!draft.value.trim()}>
          {t("message.show")}
        </button>
        {shown && (
          <button type="button" class="plain-button" onClick={() => announce("")}>
            {t("message.take_away")}
          </button>
        )}
      </form>
    </section>
  );
}
