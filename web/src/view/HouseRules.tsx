import { t } from "../words/words";

/** The house rules, if there are any. */
export function HouseRules({ rules }: { rules: readonly string[] }) {
  if (rules.length === 0) return null;
  return (
    <ul class="house-rules" aria-label={t("branding.rules")}>
      {rules.map((rule) => (
        <li key={rule}>
          <bdi>{rule}</bdi>
        </li>
      ))}
    </ul>
  );
}
