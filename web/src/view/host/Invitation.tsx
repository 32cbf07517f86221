import { useSignal } from "@preact/signals";
import type { Invite } from "../../messages";
import { t } from "../../words/words";
import { useActions, useState } from "../context";
import { whenWords } from "../pageWords";
import { ToCopy } from "./ToCopy";

const HOUR_S = 3600;
const DAY_S = 24 * HOUR_S;
const DURATIONS = [
  [HOUR_S, "invitation.hour"],
  [DAY_S, "invitation.day"],
  [7 * DAY_S, "invitation.week"],
  [30 * DAY_S, "invitation.month"],
] as const;
const MOST_USES = 1000;

/** Makes a link that lets people watch, or also drive. */
export function Invitation() {
  const { actAsHost } = useActions();
  const purpose = useSignal<Invite["purpose"]>("queue");
  const uses = useSignal(1);
  const validS = useSignal<number>(DAY_S);
  const make = () => {
    actAsHost({
      type: "invite",
      purpose: purpose.value,
      uses: Math.min(Math.max(Math.round(uses.value) || 1, 1), MOST_USES),
      valid_s: validS.value,
    });
  };
  return (
    <section class="host-section" aria-labelledby="invitation-title">
      <h3 id="invitation-title">{t("invitation.title")}</h3>
      <div class="host-fields">
        <label class="field">
          <span>{t("invitation.to")}</span>
          <select
            value={purpose.value}
            onChange={(event) => {
              purpose.value = event.currentTarget.value as Invite["purpose"];
            }}
          >
            <option value="queue">{t("invitation.to_drive")}</option>
            <option value="watch">{t("invitation.to_watch")}</option>
          </select>
        </label>
        <label class="field">
          <span>{t("invitation.people")}</span>
          <input
            type="number"
            min={1}
            max={MOST_USES}
            value={uses.value}
            onInput={(event) => {
              uses.value = event.currentTarget.valueAsNumber;
            }}
          />
        </label>
        <label class="field">
          <span>{t("invitation.for")}</span>
          <select
            value={validS.value}
            onChange={(event) => {
              validS.value = Number(event.currentTarget.value);
            }}
          >
            {DURATIONS.map(([seconds, code]) => (
              <option key={seconds} value={seconds}>
                {t(code)}
              </option>
            ))}
          </select>
        </label>
      </div>
      <button type="button" class="main-button" onClick={make}>
        {t("invitation.make")}
      </button>
      <MadeLink />
    </section>
  );
}

/** This page's address, with the path it may be below. */
function here(): string {
  return window.location.origin + window.location.pathname.replace(/\/$/, "");
}

/** The newest invitation. */
function MadeLink() {
  const { invitation } = useState();
  const made = invitation.value;
  if (!made) return null;
  const code = made.purpose === "queue" ? "invitation.made_to_drive" : "invitation.made_to_watch";
  return (
    <div class="made-link">
      <p class="quiet">
        {t(code, { n: made.uses, when: whenWords(made.ends_wall_ms, Date.now()) })}
      </p>
      <ToCopy name={t("invitation.link")} text={`${made.page || here()}/#invite=${made.token}`} />
    </div>
  );
}
