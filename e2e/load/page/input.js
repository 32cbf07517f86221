// Notes what the browser says of each input: [kind, name, when it was, when the page was told], in ms.
(() => {
  const noted = [];
  window.waxInputs = noted;
  const note = (event) => {
    if (!event.isTrusted || event.repeat) return;
    // A raw update is the same move, told of sooner.
    const kind = event.type === "pointerrawupdate" ? "pointermove" : event.type;
    noted.push([kind, event.code ?? "", event.timeStamp, performance.now()]);
  };
  for (const kind of [
    "keydown",
    "keyup",
    "pointerdown",
    "pointermove",
    "pointerrawupdate",
    "pointerup",
  ]) {
    addEventListener(kind, note, { capture: true });
  }
})();
