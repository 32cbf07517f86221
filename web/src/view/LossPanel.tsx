import { t } from "../words/words";
import { useState } from "./context";
import { lossSentences } from "./rules";

/** What the robot does when something fails, by the server's rules, which no page can change. */
export function LossPanel() {
  const { hello, room } = useState();
  if (!hello.value) return null;
  return (
    <>
      <ul class="sentences">
        {lossSentences(hello.value, room.value?.robot.ttl_ms ?? null).map((sentence) => (
          <li key={sentence}>{sentence}</li>
        ))}
      </ul>
      <p class="quiet">{t("rules.whose")}</p>
    </>
  );
}
