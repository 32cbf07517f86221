import type { ComponentChildren } from "preact";
import type { Served } from "../messages";
import { PLAYERS, type Preferences } from "../preferences";
import { type Box, enlargement } from "../wantedSize";
import { figure, t } from "../words/words";
import { useActions, useState } from "./context";
import {
  ageWords,
  breakWords,
  linkWords,
  msWords,
  policyWords,
  reasons,
  sentPictureWords,
  sentSoundWords,
  skewWords,
} from "./figures";
import { isUndated } from "./pageWords";
import { NAMES, numbersNamed } from "./robotNumbers";

/**
 * How well it plays, what is sent, and why. The picture age runs from when the server receives the
 * frame to when the browser presents it; the host may have measured the rest (`glass/Glass.tsx`).
 */
export function Facts() {
  const { facts, served, playout, player, room, box } = useState();
  const { pictureErrorMs, soundMs, skewMs, roundTripMs, fps } = facts.value;
  const { pauses, freezes } = facts.value;
  const pictureMs = isUndated(room.value) ? null : facts.value.pictureMs;
  const cameraMs = room.value?.host_settings.camera_delay_ms;
  const robot = room.value?.robot;
  return (
    <dl class="facts">
      <Fact name={t("facts.picture_age")}>{ageWords(pictureMs, pictureErrorMs)}</Fact>
      {pictureMs !== null && typeof cameraMs === "number" && (
        <Fact name={t("facts.end_to_end")}>{msWords(pictureMs + cameraMs)}</Fact>
      )}
      {pictureMs !== null && typeof cameraMs !== "number" && (
        <Fact name={t("facts.not_included")}>{t("facts.not_in_picture_age")}</Fact>
      )}
      <Fact name={t("facts.sound_age")}>{msWords(soundMs)}</Fact>
      <Fact name={t("facts.skew")}>{skewWords(skewMs)}</Fact>
      <Fact name={t("facts.round_trip")}>{msWords(roundTripMs)}</Fact>
      <Fact name={t("facts.frame_rate")}>{fps === null ? "–" : t("figures.fps", { fps })}</Fact>
      <Fact name={t("facts.gaps")}>{breakWords(pauses)}</Fact>
      <Fact name={t("facts.freezes")}>{breakWords(freezes)}</Fact>
      <Fact name={t("facts.policy")}>{policyWords(playout.value?.policy)}</Fact>
      <Fact name={t("facts.picture_shown")}>{shownWords(served.value, box.value)}</Fact>
      <Fact name={t("facts.picture_sent")}>{sentPictureWords(served.value)}</Fact>
      <Fact name={t("facts.sound_sent")}>{sentSoundWords(served.value)}</Fact>
      <Fact name={t("facts.player")}>
        {player.value.by === "built-in" ? t("facts.player_built_in") : t("facts.player_browser")}
      </Fact>
      <Player />
      <Fact name={t("facts.link")}>{linkWords(served.value)}</Fact>
      {robot &&
        NAMES.map((code) => {
          const numbers = numbersNamed(code, robot);
          return (
            numbers.length > 0 && (
              <Fact key={code} name={t(code)}>
                {numbers.join(", ")}
              </Fact>
            )
          );
        })}
      <Reasons sentences={reasons(playout.value, served.value, player.value)} />
    </dl>
  );
}

/** How many of the screen's pixels the picture that is sent fills. */
function shownWords(served: Served | null, box: Box | null): string {
  const [size] = served?.rendition?.split(" ") ?? [];
  if (size === undefined || !box) return "–";
  const scale = enlargement(size, box) * window.devicePixelRatio;
  return size
    .split("x")
    .map((sent) => figure(Math.round(Number(sent) * scale)))
    .join(" × ");
}

const PLAYER_NAMES = { "built-in": "facts.by_built_in", browser: "facts.by_browser" } as const;

/** The choice of sound player, to compare the two. */
function Player() {
  const { preferences } = useState();
  const { setPlayer } = useActions();
  return (
    <>
      <dt id="player">{t("facts.play_by")}</dt>
      <dd>
        <select
          aria-labelledby="player"
          value={preferences.value.player ?? ""}
          onChange={(event) =>
            setPlayer((event.currentTarget.value || null) as Preferences["player"])
          }
        >
          {PLAYERS.map((one) => (
            <option key={one} value={one ?? ""}>
              {one ? t(PLAYER_NAMES[one]) : t("facts.automatic")}
            </option>
          ))}
        </select>
      </dd>
    </>
  );
}

function Fact({ name, children }: { name: string; children: ComponentChildren }) {
  return (
    <>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </>
  );
}

function Reasons({ sentences }: { sentences: string[] }) {
  if (sentences.length === 0) return null;
  return (
    <>
      <dt>{t("facts.why")}</dt>
      {sentences.map((sentence) => (
        <dd key={sentence} class="reason">
          {sentence}
        </dd>
      ))}
    </>
  );
}
