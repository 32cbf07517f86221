import { Ask } from "../Ask";
import { useActions, useState } from "../context";
import { Switch } from "../Switch";
import { whenWords } from "../words";

/** Who may come in, and whether anybody sees and hears. */
export function Door() {
  const { room, console } = useState();
  const { actAsHost } = useActions();
  const house = room.value?.house;
  const isClosed = console.value?.closed === true;
  const opensMs = console.value?.opens_wall_ms ?? null;
  return (
    <section class="host-section" aria-labelledby="door-title">
      <h3 id="door-title">Door and privacy</h3>
      <Switch
        name="Picture and sound off for everybody"
        isOn={house?.blanked === true}
        onSwitch={(blanked) => actAsHost({ type: "blank", blanked })}
      />
      <div class="host-row">
        {house?.locked ? (
          <button
            type="button"
            class="plain-button"
            onClick={() => actAsHost({ type: "lock", locked: false })}
          >
            Let strangers in again
          </button>
        ) : (
          // One press, because a troll does not wait for a question; it can be taken back.
          <button
            type="button"
            class="plain-button"
            onClick={() => actAsHost({ type: "lock", locked: true })}
          >
            Only invited people
          </button>
        )}
        {isClosed ? (
          <button
            type="button"
            class="plain-button"
            onClick={() => actAsHost({ type: "close", closed: false })}
          >
            Open
          </button>
        ) : (
          <Ask
            name="Close for today…"
            question="Send all guests away and close?"
            answers={{ Close: () => actAsHost({ type: "close", closed: true }) }}
          />
        )}
      </div>
      {isClosed && (
        <p class="quiet">
          Closed to guests{opensMs !== null && `; opens ${whenWords(opensMs, Date.now())}`}.
        </p>
      )}
    </section>
  );
}
