import { brandedPage, welcomeWords } from "../branding/page";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { HouseRules } from "./HouseRules";

/** For a first visit: three lines, and the house rules. */
export function Welcome() {
  const state = useState();
  const { keep } = useActions();
  if (state.preferences.value.welcomed || !state.hello.value) return null;
  return (
    <section class="welcome" aria-labelledby="welcome-title">
      <h2 id="welcome-title">{t("welcome.title")}</h2>
      <div class="welcome-lines">
        {welcomeWords(state).map((line) => (
          <p key={line}>
            <bdi>{line}</bdi>
          </p>
        ))}
      </div>
      <HouseRules rules={brandedPage(state).rules} />
      <button type="button" class="plain-button" onClick={() => keep({ welcomed: true })}>
        {t("welcome.understood")}
      </button>
    </section>
  );
}
