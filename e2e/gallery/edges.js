// What must hold in forced colours, where the page's colours, and so its backgrounds, are gone: a
// button is known by its edge, and so is what is chosen. A sentence for each that is not.
() => {
  const shown = (what) =>
    [...document.querySelectorAll(what)].filter((one) =>
      one.checkVisibility({ visibilityProperty: true }),
    );
  const edges = (one) =>
    [null, "::before", "::after"]
      .map((part) => {
        const style = getComputedStyle(one, part);
        const { borderTopStyle, borderTopWidth, borderTopColor, outlineStyle } = style;
        return [borderTopStyle, borderTopWidth, borderTopColor, outlineStyle].join(" ");
      })
      .join();
  const isBare = (one) => {
    const { borderTopStyle, borderTopWidth, outlineStyle, forcedColorAdjust } =
      getComputedStyle(one);
    const isFramed = borderTopStyle !== "none" && parseFloat(borderTopWidth) >= 1;
    return !isFramed && outlineStyle === "none" && forcedColorAdjust !== "none";
  };
  const isChosen = (one) => one.checked ?? one.ariaPressed === "true";
  const group = (one) => one.name || one.parentElement;
  const choices = shown("[aria-pressed]:enabled, input[type=radio]:enabled").filter(
    (one) => one.type !== "radio" || getComputedStyle(one).appearance === "none",
  );
  const looksAlike = (one) =>
    choices.some(
      (other) =>
        group(other) === group(one) && !isChosen(other) && edges(other) === edges(one),
    );
  const bare = shown("button:enabled")
    .filter(isBare)
    .map((one) => `“${(one.ariaLabel ?? one.innerText).trim()}” has no edge in forced colours`);
  const alike = choices
    .filter(isChosen)
    .filter(looksAlike)
    .map((one) => `“${(one.closest("label") ?? one).innerText.trim()}” does not look chosen`);
  return [...bare, ...alike];
}
