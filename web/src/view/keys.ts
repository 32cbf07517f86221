/** Keys that press the button which has the focus, by their place on the keyboard. */
export const PRESSING = new Set(["Space", "Enter", "NumpadEnter"]);
