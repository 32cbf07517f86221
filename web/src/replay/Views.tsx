import { type Signal, useComputed, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { TapeCamera, TapeContent } from "../messages";
import { drivingView } from "../view/pageWords";
import { t } from "../words/words";
import type { Player } from "./player";

/** A picture missing for less than this is not mentioned. */
const MISSING_MS = 500;

interface Props {
  content: TapeContent;
  player: Player | null;
  momentMs: Signal<number>;
  /** The driving view's element. */
  picture: RefObject<HTMLVideoElement | null>;
}

/** The driving view and the cameras beside it at the same moment; a tap or C makes one large. */
export function Views({ content, player, momentMs, picture }: Props) {
  const chosen = useSignal<number | null>(null);
  const { cameras } = content;
  const isThere = cameras.some((one) => one.number === chosen.value);
  const large = isThere ? chosen.value : null;

  useEffect(() => {
    const order = [null, ...cameras.map((one) => one.number)];
    const press = (event: KeyboardEvent) => {
      const isElsewhere = event.target instanceof Element && event.target.closest("select");
      const isOther = event.ctrlKey || event.altKey || event.metaKey;
      if (event.key !== "c" || isOther || isElsewhere) return;
      chosen.value = order[(order.indexOf(large) + 1) % order.length] ?? null;
    };
    window.addEventListener("keydown", press);
    return () => window.removeEventListener("keydown", press);
  }, [cameras, chosen, large]);

  const enlarge = (camera: number | null) => () => {
    chosen.value = camera;
  };
  return (
    <div class={cameras.length > 0 ? "replay-views has-small" : "replay-views"}>
      <div class={large === null ? "replay-view is-large" : "replay-view"}>
        {/* biome-ignore lint/a11y/useMediaCaption: there are none of what a robot hears */}
        <video ref={picture} playsInline preload="auto" hidden={!content.has_picture} />
        {!content.has_picture && <p>{t("replay.no_picture")}</p>}
        {large !== null && <Enlarge name={drivingView()} onTap={enlarge(null)} />}
      </div>
      {player &&
        cameras.map((one) => (
          <Camera
            key={`${content.name}/${one.number}`}
            url={`media/${encodeURIComponent(content.name)}/${one.number}`}
            camera={one}
            player={player}
            momentMs={momentMs}
            isLarge={one.number === large}
            onTap={enlarge(one.number)}
          />
        ))}
    </div>
  );
}

interface CameraProps {
  url: string;
  camera: TapeCamera;
  player: Player;
  momentMs: Signal<number>;
  isLarge: boolean;
  onTap: () => void;
}

function Camera({ url, camera, player, momentMs, isLarge, onTap }: CameraProps) {
  const video = useRef<HTMLVideoElement>(null);
  useEffect(
    () => (video.current ? player.attach(video.current, camera.began_ms) : undefined),
    [player, camera],
  );
  const isMissing = useComputed(() => {
    const dueMs = momentMs.value - camera.began_ms;
    const lengthMs = (video.current?.duration ?? Infinity) * 1000;
    return dueMs < -MISSING_MS || dueMs > lengthMs + MISSING_MS;
  });
  const kinds = [
    "replay-view",
    ...(isLarge ? ["is-large"] : []),
    ...(isMissing.value ? ["is-missing"] : []),
  ];
  return (
    <div class={kinds.join(" ")}>
      <video ref={video} src={url} muted playsInline preload="auto" />
      {isMissing.value && <p>{t("replay.no_picture_then")}</p>}
      {isLarge ? (
        <p class="replay-view-name">{camera.name}</p>
      ) : (
        <Enlarge name={camera.name} onTap={onTap} />
      )}
    </div>
  );
}

/** Covers a small picture: its name, and a tap makes it large. */
function Enlarge({ name, onTap }: { name: string; onTap: () => void }) {
  return (
    <button
      type="button"
      class="replay-view-button"
      title={t("replay.key", { key: "C" })}
      aria-label={t("replay.enlarge", { name })}
      onClick={onTap}
    >
      <span class="replay-view-name">{name}</span>
    </button>
  );
}
