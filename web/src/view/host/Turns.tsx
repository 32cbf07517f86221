import { named } from "../../words/named";
import { t } from "../../words/words";
import { Ask } from "../Ask";
import { useActions, useState } from "../context";
import { Switch } from "../Switch";

const FRACTIONS = [1, 0.75, 0.5, 0.25] as const;

/** The queue, the turn, and how fast guests may drive. */
export function Turns() {
  const { room, operator } = useState();
  const { actAsHost } = useActions();
  const { host_settings: settings, turn, voice } = room.value ?? {};
  return (
    <section class="host-section" aria-labelledby="turns-title">
      <h3 id="turns-title">{t("host.turns")}</h3>
      <div class="host-row">
        <Switch
          name={t("host.pause")}
          isOn={settings?.held === true}
          onSwitch={(held) => actAsHost({ type: "hold_queue", held })}
        />
        {voice && (
          <Switch
            name={t("host.mute_voices")}
            isOn={voice.muted}
            onSwitch={(muted) => actAsHost({ type: "mute_voices", muted })}
          />
        )}
        {operator.value && turn && (
          <Ask
            key={turn.number}
            name={t("host.end_turn")}
            question={t("host.end_turn_question", { name: named(operator.value.name) })}
            answers={{
              [t("host.end_it")]: () => actAsHost({ type: "end_turn", turn: turn.number }),
            }}
          />
        )}
      </div>
      <label class="field">
        <span>{t("host.limit")}</span>
        <select
          value={settings?.max_fraction ?? 1}
          onChange={(event) => {
            const fraction = Number(event.currentTarget.value);
            actAsHost({ type: "limit_speed", fraction });
          }}
        >
          {FRACTIONS.map((fraction) => (
            <option key={fraction} value={fraction}>
              {fraction === 1
                ? t("host.full_speed")
                : t("host.part_speed", { percent: fraction * 100 })}
            </option>
          ))}
        </select>
      </label>
    </section>
  );
}
