import { MAX_TASK_CHARS } from "../messages";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { LineField } from "./LineField";

/**
 * Asks operators, and those who wait, once what they are going to do; only where the host wants it.
 */
export function TaskField() {
  const { room, me, task } = useState();
  const { setTask } = useActions();
  const drives = me.value && me.value.role !== "observer";
  if (!room.value?.tape?.asks_task || !drives || task.value !== "") return null;
  return (
    <LineField
      label={t("tape.task")}
      maxLength={MAX_TASK_CHARS}
      autocomplete="off"
      placeholder={t("tape.task_why")}
      value=""
      onSet={setTask}
    />
  );
}
