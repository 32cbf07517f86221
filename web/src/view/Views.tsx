/** Shows the driving view and the other cameras; which is large: `../cameras.ts`. */

import { useComputed } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { CameraInfo } from "../messages";
import { t } from "../words/words";
import { useActions, useSession, useState } from "./context";
import { late } from "./late";
import { cameraProblem, drivingView } from "./pageWords";

export const PathArc = late(async () => (await import("../path/PathArc")).PathArc, {
  isForDriving: true,
  isOverPicture: true,
});

interface Props {
  isShown: boolean;
  /** The driving view's element. */
  video: RefObject<HTMLVideoElement | null>;
}

/** The driving view and the cameras beside it: one large, the others small, or side by side. */
export function Views({ isShown, video }: Props) {
  const { cameras, large, preferences, drivingTurn } = useState();
  const others = isShown ? cameras.value : [];
  const isLarge = large.value === null || others.length === 0;
  const hasSmall = others.length > 0 && (preferences.value.cameras || !isLarge);
  const kinds = [
    "views",
    ...(hasSmall ? ["has-small"] : []),
    ...(others.length > 2 ? ["is-many"] : []),
    ...(drivingTurn.value !== null && !isLarge ? ["is-watched"] : []),
  ];
  return (
    <div class={kinds.join(" ")}>
      <div class={isLarge ? "view is-large" : "view is-small is-driving-view"}>
        <video ref={video} class={isShown ? "" : "is-off"} muted autoplay playsinline />
        {isLarge && <Path />}
        {!isLarge && <Enlarge camera={null} name={drivingView()} why={null} />}
      </div>
      {others.map((camera, at) => (
        <Camera key={camera.name} at={at} camera={camera} />
      ))}
    </div>
  );
}

/** The predicted path, once there is a picture to draw it on. */
function Path() {
  const { facts, hello, preferences } = useState();
  const isSeen = useComputed(() => facts.value.pictureMs !== null);
  const isWanted = preferences.value.path && hello.value?.robot.camera;
  return isWanted && isSeen.value ? <PathArc /> : null;
}

function Camera({ at, camera }: { at: number; camera: CameraInfo }) {
  const session = useSession();
  const { large, preferences, room, served, staleCameras } = useState();
  const video = useRef<HTMLVideoElement>(null);
  const isLarge = large.value === at;
  useEffect(() => {
    session.attachCamera(at, video.current);
    return () => session.attachCamera(at, null);
  }, [session, at]);
  const why = cameraProblem(at, room.value, served.value);
  const isLive = why === null && !staleCameras.value.has(at);
  const isOff = !isLarge && !preferences.value.cameras;
  const kinds = ["view", isLarge ? "is-large" : "is-small", ...(isLive ? [] : ["is-old"])];
  return (
    <div class={kinds.join(" ")} hidden={isOff}>
      <video ref={video} muted autoplay playsinline />
      {isLarge ? (
        <p class="view-name" dir="auto">
          {camera.name}
        </p>
      ) : (
        <Enlarge camera={at} name={camera.name} why={why} />
      )}
    </div>
  );
}

/** Covers a small picture with its name and any problem; a tap makes it large. */
function Enlarge(props: { camera: number | null; name: string; why: string | null }) {
  const { enlarge } = useActions();
  return (
    <button
      type="button"
      class="view-button"
      aria-label={t("robot.enlarge", { name: props.name })}
      onClick={() => enlarge(props.camera)}
    >
      {props.why !== null && <span class="view-why">{props.why}</span>}
      <bdi class="view-name">{props.name}</bdi>
    </button>
  );
}
