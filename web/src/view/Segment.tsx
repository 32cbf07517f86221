import type { ComponentChildren } from "preact";

interface Props {
  isChosen: boolean;
  isDisabled?: boolean;
  onChoose: () => void;
  children: ComponentChildren;
}

/**
 * One of a few exclusive choices beside the picture. Not a radio button, which would take the arrow
 * keys when focused; here they must drive the robot, as everywhere on the page.
 */
export function Segment({ isChosen, isDisabled = false, onChoose, children }: Props) {
  return (
    <button
      type="button"
      class="segment"
      aria-pressed={isChosen}
      disabled={isDisabled}
      onClick={onChoose}
    >
      {children}
    </button>
  );
}
