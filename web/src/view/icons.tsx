/** Small drawings; the words beside them carry the meaning. */

import type { ComponentChildren } from "preact";

function Icon({ children }: { children: ComponentChildren }) {
  return (
    <svg viewBox="0 0 24 24" aria-hidden="true" class="icon">
      {children}
    </svg>
  );
}

/** Points up; the style sheet turns it. */
export function ArrowIcon() {
  return (
    <Icon>
      <path d="M12 5 20 15H4Z" stroke-linejoin="round" />
    </Icon>
  );
}

/** Turns right; the style sheet mirrors it. */
export function TurnIcon() {
  return (
    <Icon>
      <path d="M5 19a8 8 0 1 1 13.500-5" class="line" stroke-linecap="round" />
      <path d="M22.500 11.500 19 18l-5.500-5Z" stroke-linejoin="round" />
    </Icon>
  );
}

export function MutedIcon() {
  return (
    <Icon>
      <path d="M4 10v4h3l5 4V6L7 10Z" stroke-linejoin="round" />
      <path d="m16 9.5 5 5M21 9.5l-5 5" class="line" stroke-linecap="round" />
    </Icon>
  );
}

export function BatteryIcon() {
  return (
    <Icon>
      <path d="M4 8h14v8H4Z" class="line" stroke-linejoin="round" />
      <path d="M20.5 11v2M7 11v2M10.500 11v2" stroke-linecap="round" />
    </Icon>
  );
}

export function BumperIcon() {
  return (
    <Icon>
      <path d="M4 17a8 8 0 0 1 16 0" class="line" stroke-linecap="round" />
      <path d="M12 4v3M6 6l1.500 2.500M18 6l-1.500 2.500" stroke-linecap="round" />
    </Icon>
  );
}

export function CloseIcon() {
  return (
    <Icon>
      <path d="m6 6 12 12M18 6 6 18" class="line" stroke-linecap="round" />
    </Icon>
  );
}

export function EarIcon() {
  return (
    <Icon>
      <path d="M4 10v4h3l5 4V6L7 10Z" stroke-linejoin="round" />
      <path d="M15.5 9a4 4 0 0 1 0 6M18 6.5a8 8 0 0 1 0 11" class="line" stroke-linecap="round" />
    </Icon>
  );
}

export function CurtainIcon() {
  return (
    <Icon>
      <path d="M3 4h18v3H3ZM4 7v13M20 7v13M8 7v13M12 7v13M16 7v13" stroke-linecap="round" />
    </Icon>
  );
}
