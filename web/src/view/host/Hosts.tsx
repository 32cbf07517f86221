import { t } from "../../words/words";
import { Ask } from "../Ask";
import { useActions, useState } from "../context";

/** The other hosts who are signed in, all of whom can be signed out. */
export function Hosts() {
  const { console } = useState();
  const { actAsHost } = useActions();
  const reused = console.value?.reused;
  return (
    <section class="host-section" aria-labelledby="hosts-title">
      <h3 id="hosts-title">{t("host.others")}</h3>
      {reused && <p role="alert">{t("host.reused", { address: reused })}</p>}
      <Ask
        name={t("host.sign_out_name")}
        question={t("host.sign_out_question")}
        answers={{ [t("host.sign_out")]: () => actAsHost({ type: "sign_out_others" }) }}
      />
    </section>
  );
}
