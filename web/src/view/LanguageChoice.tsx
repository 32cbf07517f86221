import { LANGUAGES } from "../words/language";
import { t } from "../words/words";
import { useActions, useState } from "./context";

/** The page's language, each by its own name, so that its speakers find it. */
export function LanguageChoice() {
  const { preferences } = useState();
  const { setLanguage } = useActions();
  return (
    <label class="field">
      <span>{t("language.title")}</span>
      <select
        value={preferences.value.language ?? ""}
        onChange={(event) => setLanguage(event.currentTarget.value || null)}
      >
        <option value="">{t("language.automatic")}</option>
        {LANGUAGES.map(({ tag, name }) => (
          <option key={tag} value={tag} lang={tag}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}
