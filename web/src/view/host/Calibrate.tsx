import "../../style/calibrate.css";
import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Camera } from "../../path/camera";
import { gridOf } from "../../path/grid";
import { configurationOf, solve } from "../../path/solve";
import { aspectOf, isCentred } from "../../path/view";
import { t } from "../../words/words";
import { useSession, useState } from "../context";
import { Lines } from "./Lines";

const ROW_STEP = 0.002;

/**
 * Calibrates the camera by two marks on the floor. Nothing is sent: the result is for the
 * configuration file.
 */
export function Calibrate() {
  const state = useState();
  const heightM = useSignal(state.hello.value?.robot.camera?.height_m ?? 0.3);
  const nearM = useSignal(0.5);
  const farM = useSignal(1.5);
  const nearRow = useSignal<number | null>(null);
  const farRow = useSignal<number | null>(null);
  if (!state.preferences.value.picture) return <p>{t("path.no_picture")}</p>;
  if (!isCentred(state)) return <p>{t("path.not_centred")}</p>;

  const aspect = aspectOf(state);
  const isWhole = nearRow.value !== null && farRow.value !== null;
  const solution = solve(
    heightM.value,
    { distanceM: nearM.value, row: nearRow.value ?? 0 },
    { distanceM: farM.value, row: farRow.value ?? 0 },
    aspect,
  );
  const camera = isWhole && solution.is === "found" ? solution.camera : null;

  /** The first click sets the nearer mark, the second the farther, later ones the closest. */
  const mark = (row: number) => {
    if (nearRow.value === null) nearRow.value = row;
    else if (farRow.value === null) farRow.value = row;
    else nearest(row, nearRow as Signal<number>, farRow as Signal<number>).value = row;
  };
  return (
    <div class="calibrate">
      <p class="quiet">{t("path.explain")}</p>
      <div class="host-fields">
        <Metres name={t("path.height")} value={heightM} />
        <Metres name={t("path.near")} value={nearM} />
        <Metres name={t("path.far")} value={farM} />
      </div>
      <Marked
        rows={[nearRow.value, farRow.value]}
        camera={camera}
        aspect={aspect}
        widthM={state.hello.value?.robot.width_m ?? null}
        onMark={mark}
      />
      <p role="status">
        {isWhole
          ? t("path.compare")
          : t(nearRow.value === null ? "path.click_near" : "path.click_far")}
      </p>
      <Row name={t("path.near_row")} row={nearRow} />
      <Row name={t("path.far_row")} row={farRow} />
      {isWhole && solution.is === "impossible" && (
        <p class="calibrate-problem" role="alert">
          {t(solution.why)}
        </p>
      )}
      {camera && (
        <>
          <p>
            {t("path.found", {
              tilt: Math.round(camera.tiltDeg * 10) / 10,
              fov: Math.round(camera.fovDeg * 10) / 10,
            })}
          </p>
          <Lines text={configurationOf(camera)} />
        </>
      )}
    </div>
  );
}

function nearest(row: number, one: Signal<number>, other: Signal<number>): Signal<number> {
  return Math.abs(one.value - row) < Math.abs(other.value - row) ? one : other;
}

function Metres({ name, value }: { name: string; value: Signal<number> }) {
  return (
    <label class="field">
      <span>{name}</span>
      <input
        type="number"
        min={0}
        step="any"
        inputMode="decimal"
        value={value.value}
        onInput={(event) => {
          value.value = event.currentTarget.valueAsNumber;
        }}
      />
    </label>
  );
}

/** A mark's row as a slider, for users who cannot click on the picture; from its lower edge. */
function Row({ name, row }: { name: string; row: Signal<number | null> }) {
  return (
    <label class="field">
      <span>{name}</span>
      <input
        type="range"
        min={0}
        max={1}
        step={ROW_STEP}
        value={1 - (row.value ?? 1)}
        onInput={(event) => {
          row.value = 1 - event.currentTarget.valueAsNumber;
        }}
      />
    </label>
  );
}

interface MarkedProps {
  rows: (number | null)[];
  camera: Camera | null;
  aspect: number;
  widthM: number | null;
  onMark: (row: number) => void;
}

/** The driving view with the marks, and the floor's grid as the calibrated camera would see it. */
function Marked({ rows, camera, aspect, widthM, onMark }: MarkedProps) {
  const session = useSession();
  const { isConnected } = useState();
  const video = useRef<HTMLVideoElement>(null);
  const isThere = isConnected.value;
  useEffect(() => {
    if (video.current && isThere) video.current.srcObject = session.pictureStream();
  }, [session, isThere]);
  const grid = camera ? gridOf(camera, aspect, widthM) : "";
  return (
    <div class="calibrate-picture">
      <video ref={video} muted autoplay playsinline />
      {/* biome-ignore lint/a11y/useKeyWithClickEvents: by keyboard the sliders do the same */}
      <svg
        role="img"
        aria-label={t("path.picture")}
        viewBox="0 0 100 100"
        preserveAspectRatio="none"
        onClick={(event) => {
          const box = event.currentTarget.getBoundingClientRect();
          if (box.height > 0) onMark((event.clientY - box.top) / box.height);
        }}
      >
        <path class="calibrate-axis" d="M50 0V100" />
        <path class="path-seam" d={grid} />
        <path class="path-lane" d={grid} />
        {rows.map((row, at) =>
          row === null ? null : (
            <path
              key={at === 0 ? "near" : "far"}
              class="calibrate-mark"
              d={`M40 ${100 * row}H60`}
            />
          ),
        )}
      </svg>
    </div>
  );
}
