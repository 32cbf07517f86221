import type { ComponentChildren } from "preact";

interface Props {
  isChosen: boolean;
  isDisabled?: boolean;
  onChoose: () => void;
  children: ComponentChildren;
}

/**
 * One of a few that exclude each other, beside the picture. No radio button: with the focus that
 * would take the arrow keys, which are to drive the robot as everywhere on the page.
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
