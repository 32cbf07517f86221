import { useSignal } from "@preact/signals";
import { t } from "../../words/words";
import { useActions, useState } from "../context";

const MAX_CHARS = 200;

/** A message that everybody sees until it is removed, or until a time. */
export function Message() {
  const { room } = useState();
  const { actAsHost } = useActions();
  const draft = useSignal("");
  const ends = useSignal("");
  const shown = room.value?.host_settings.message ?? "";
  const announce = (text: string) => {
    const for_s = text ? secondsUntil(ends.value, new Date()) : null;
    actAsHost({ type: "announce", text, for_s });
    draft.value = "";
    ends.value = "";
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
        <label class="field">
          <span>{t("message.ends")}</span>
          <input
            type="time"
            value={ends.value}
            onInput={(event) => {
              ends.value = event.currentTarget.value;
            }}
          />
        </label>
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

/** How long until a clock here shows this time, as `15:00`; null for none. */
function secondsUntil(time: string, now: Date): number | null {
  const [hours, minutes] = time.split(":").map(Number);
  if (hours === undefined || minutes === undefined) return null;
  const ends = new Date(now);
  ends.setHours(hours, minutes, 0, 0);
  if (ends <= now) ends.setDate(ends.getDate() + 1);
  return Math.ceil((ends.getTime() - now.getTime()) / 1000);
}
