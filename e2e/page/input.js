// Notes what the browser says of each input, with the time of its event, and has a gamepad that a
// test moves: [kind, name, ms].
(() => {
  const noted = [];
  window.waxInputs = noted;
  const note = (event) => {
    if (event.isTrusted && !event.repeat) noted.push([event.type, event.code ?? "", event.timeStamp]);
  };
  for (const kind of ["keydown", "keyup", "pointerdown", "pointermove", "pointerup"]) {
    addEventListener(kind, note, { capture: true });
  }

  // The standard layout: what a browser that knows the gamepad makes of any.
  let pad = null;
  const button = (pressed) => ({ pressed, touched: pressed, value: pressed ? 1 : 0 });
  navigator.getGamepads = () => (pad ? [pad, null, null, null] : [null, null, null, null]);
  window.waxPad = {
    connect() {
      pad = {
        id: "Injected gamepad (STANDARD GAMEPAD)",
        index: 0,
        connected: true,
        mapping: "standard",
        timestamp: performance.now(),
        axes: [0, 0, 0, 0],
        buttons: Array.from({ length: 17 }, () => button(false)),
      };
      dispatchEvent(Object.assign(new Event("gamepadconnected"), { gamepad: pad }));
    },
    push(axis, value) {
      const now = performance.now();
      const axes = pad.axes.map((old, i) => (i === axis ? value : old));
      pad = { ...pad, axes, timestamp: now };
      noted.push([value === 0 ? "padup" : "paddown", "", now]);
    },
    press(which, isDown) {
      const buttons = pad.buttons.map((old, i) => (i === which ? button(isDown) : old));
      pad = { ...pad, buttons, timestamp: performance.now() };
    },
  };
})();
