// What must hold in every state and window: returns a sentence for each thing that does not.
(button) => {
  const found = [];
  const { clientWidth, scrollWidth } = document.documentElement;
  if (scrollWidth > clientWidth) {
    const wide = [...document.body.querySelectorAll("*")]
      .filter((one) => one.getBoundingClientRect().right > clientWidth + 1)
      .map(said);
    const who = wide.length > 0 ? `: ${wide.slice(-3).join(", ")}` : "";
    found.push(`it scrolls sideways, ${scrollWidth} px in a window of ${clientWidth} px${who}`);
  }

  if (button) {
    const { left, right, top, bottom, width, height } = button.getBoundingClientRect();
    const isInside = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
    if (!isInside || !button.checkVisibility()) {
      found.push(`Stop is not in the window: ${[left, top, right, bottom].map(Math.round)}`);
    } else {
      // Within the ellipse that even a round button fills.
      const covers = new Set();
      for (const across of [-0.34, 0, 0.34]) {
        for (const along of [-0.34, 0, 0.34]) {
          const x = left + width * (0.5 + across);
          const y = top + height * (0.5 + along);
          const hit = document.elementFromPoint(x, y);
          if (hit && !button.contains(hit)) covers.add(said(hit));
        }
      }
      if (covers.size > 0) found.push(`Stop is covered by ${[...covers].join(" and ")}`);
    }
  }

  const CONTROLS =
    "a[href], button, input, select, textarea, summary, [role=button], [role=switch], [role=slider]";
  for (const control of document.querySelectorAll(CONTROLS)) {
    const isDisabled = control.disabled || control.ariaDisabled === "true" || control.type === "hidden";
    const isSeen = control.checkVisibility({ visibilityProperty: true, contentVisibilityAuto: true });
    if (isDisabled || !isSeen || control.closest("[inert]") || isInSentence(control)) continue;
    // Where a label belongs to it, that is pressed as well.
    const boxes = [control, ...(control.labels ?? [])].map((one) => one.getBoundingClientRect());
    if (boxes.some(({ width, height }) => width >= 43.5 && height >= 43.5)) continue;
    const { left, top, width, height } = boxes[0];
    // It may look smaller than it is to be pressed.
    if (isPressed(control, left + width / 2, top + height / 2)) continue;
    found.push(`${said(control)} is ${Math.round(width)} × ${Math.round(height)} px, not 44`);
  }
  return found;

  function isPressed(control, x, y) {
    const edges = [[-21.5, 0], [21.5, 0], [0, -21.5], [0, 21.5]];
    return edges.every(([across, along]) => {
      const hit = document.elementFromPoint(x + across, y + along);
      return hit !== null && control.contains(hit);
    });
  }

  // A link between words is as high as its line.
  function isInSentence(control) {
    const isLink = control.localName === "a" && getComputedStyle(control).display === "inline";
    return isLink && control.parentElement.innerText.trim() !== control.innerText.trim();
  }

  function said(element) {
    const name = element.getAttribute("aria-label") ?? element.innerText ?? "";
    const kind = element.className && typeof element.className === "string" ? `.${element.className}` : "";
    return `<${element.localName}${kind.replaceAll(" ", ".")}> “${name.trim().slice(0, 30)}”`;
  }
}
