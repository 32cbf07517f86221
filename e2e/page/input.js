// Notes what the browser says of each input, with the time of its event: [kind, name, ms].
(() => {
  const noted = [];
  window.waxInputs = noted;
  const note = (event) => {
    if (event.isTrusted && !event.repeat) noted.push([event.type, event.code ?? "", event.timeStamp]);
  };
  for (const kind of ["keydown", "keyup", "pointerdown", "pointermove", "pointerup"]) {
    addEventListener(kind, note, { capture: true });
  }
})();
