import type { GaugeInfo, RobotStatus } from "../messages";
import { t } from "../words/words";
import { useState } from "./context";
import { gaugeWords } from "./gaugeWords";

/** The values that the robot reports, each with its place on its scale. */
export function Gauges() {
  const { hello, room } = useState();
  const gauges = hello.value?.gauges ?? [];
  const robot = room.value?.robot;
  if (gauges.length === 0 || !robot) return null;
  return (
    <section class="gauges" aria-label={t("controls.gauges")}>
      <h3>{t("controls.gauges")}</h3>
      <dl>
        {gauges.map((gauge) => (
          <Gauge key={gauge.name} gauge={gauge} robot={robot} />
        ))}
      </dl>
    </section>
  );
}

function Gauge({ gauge, robot }: { gauge: GaugeInfo; robot: RobotStatus }) {
  const { name, label, min, max } = gauge;
  const value = robot.gauges[name];
  const level = robot.beyond[name];
  return (
    <div class={level ? `gauge is-${level}` : "gauge"}>
      <dt>
        <bdi>{label}</bdi>
      </dt>
      <dd>
        <span class="figure">{gaugeWords(gauge, value)}</span>
        {level && (
          <span class="gauge-level">
            {t(level === "stop" ? "controls.gauge_stops" : "controls.gauge_warns")}
          </span>
        )}
      </dd>
      <dd class="gauge-scale" aria-hidden="true">
        <meter min={min} max={max} value={value ?? min} />
      </dd>
    </div>
  );
}

/** Over the picture: only the values beyond a limit. */
export function GaugeWarnings() {
  const { hello, room } = useState();
  const robot = room.value?.robot;
  const gauges = (hello.value?.gauges ?? []).filter(({ name }) => robot?.beyond[name]);
  return (
    <>
      {gauges.map((gauge) => (
        <span key={gauge.name} class="chip is-poor">
          <bdi>{gauge.label}</bdi>
          <span class="figure">{gaugeWords(gauge, robot?.gauges[gauge.name])}</span>
        </span>
      ))}
    </>
  );
}
