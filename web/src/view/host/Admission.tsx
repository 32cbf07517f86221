import { t } from "../../words/words";
import { Ask } from "../Ask";
import { useActions, useState } from "../context";
import { whenWords } from "../pageWords";
import { Switch } from "../Switch";

/** Admission: who may come in, and whether anybody sees and hears. */
export function Admission() {
  const { room, console } = useState();
  const { actAsHost } = useActions();
  const settings = room.value?.host_settings;
  const isClosed = console.value?.closed === true;
  const opensMs = console.value?.opens_wall_ms ?? null;
  return (
    <section class="host-section" aria-labelledby="door-title">
      <h3 id="door-title">{t("door.title")}</h3>
      <Switch
        name={t("door.blank")}
        isOn={settings?.blanked === true}
        onSwitch={(blanked) => actAsHost({ type: "blank", blanked })}
      />
      <div class="host-row">
        {settings?.locked ? (
          <button
            type="button"
            class="plain-button"
            onClick={() => actAsHost({ type: "lock", locked: false })}
          >
            {t("door.unlock")}
          </button>
        ) : (
          // No question, because a troll does not wait for one; the action can be undone.
          <button
            type="button"
            class="plain-button"
            onClick={() => actAsHost({ type: "lock", locked: true })}
          >
            {t("door.lock")}
          </button>
        )}
        {isClosed ? (
          <button
            type="button"
            class="plain-button"
            onClick={() => actAsHost({ type: "close", closed: false })}
          >
            {t("door.open")}
          </button>
        ) : (
          <Ask
            name={t("door.close_name")}
            question={t("door.close_question")}
            answers={{ [t("door.close")]: () => actAsHost({ type: "close", closed: true }) }}
          />
        )}
      </div>
      {isClosed && (
        <p class="quiet">
          {opensMs === null
            ? t("door.closed")
            : t("door.closed_until", { when: whenWords(opensMs, Date.now()) })}
        </p>
      )}
    </section>
  );
}
