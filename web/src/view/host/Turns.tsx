import { Ask } from "../Ask";
import { useActions, useState } from "../context";
import { Switch } from "../Switch";
import { named } from "../words";

const FRACTIONS = [1, 0.75, 0.5, 0.25] as const;

/** The queue, the turn, and how fast guests may drive. */
export function Turns() {
  const { room, operator } = useState();
  const { actAsHost } = useActions();
  const { house, turn, voice } = room.value ?? {};
  return (
    <section class="host-section" aria-labelledby="turns-title">
      <h3 id="turns-title">Turns</h3>
      <div class="host-row">
        <Switch
          name="Pause the queue"
          isOn={house?.held === true}
          onSwitch={(held) => actAsHost({ type: "hold_queue", held })}
        />
        {voice && (
          <Switch
            name="Mute all voices"
            isOn={voice.muted}
            onSwitch={(muted) => actAsHost({ type: "mute_voices", muted })}
          />
        )}
        {operator.value && turn && (
          <Ask
            key={turn.number}
            name="End this turn…"
            question={`End the turn of ${named(operator.value.name)}?`}
            answers={{ "End it": () => actAsHost({ type: "end_turn", turn: turn.number }) }}
          />
        )}
      </div>
      <label class="field">
        <span>Guests drive at most at</span>
        <select
          value={house?.max_fraction ?? 1}
          onChange={(event) => {
            const fraction = Number(event.currentTarget.value);
            actAsHost({ type: "limit_speed", fraction });
          }}
        >
          {FRACTIONS.map((fraction) => (
            <option key={fraction} value={fraction}>
              {fraction === 1 ? "full speed" : `${fraction * 100} % speed`}
            </option>
          ))}
        </select>
      </label>
    </section>
  );
}
